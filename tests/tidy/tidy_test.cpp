// Properties of the source itself: who includes whom, what the flight libraries call, and house style.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tidy/output_of.hpp"

namespace {

using ilp::test::output_of;

namespace fs = std::filesystem;

const fs::path root = ILP_SOURCE_DIR;

bool is_source(const fs::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".hpp" || extension == ".cpp" || extension == ".inc" || extension == ".c" || extension == ".h";
}

std::vector<std::string> sources_below(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    if (entry.is_regular_file() && is_source(entry.path())) files.push_back(fs::relative(entry.path(), root).string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> lines_of(const std::string& file) {
  std::ifstream in(root / file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

struct Include {
  std::string file;
  std::size_t line;
  std::string target;
  bool system;
};

std::vector<Include> includes_of(const std::string& file) {
  static const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<Include> includes;
  const std::vector<std::string> lines = lines_of(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::smatch match;
    if (std::regex_search(lines[i], match, pattern)) includes.push_back({file, i + 1, match[2], match[1] == "<"});
  }
  return includes;
}

bool starts_with(const std::string& text, const std::string& prefix) {
  return text.rfind(prefix, 0) == 0;
}

bool any_prefix(const std::string& text, const std::vector<std::string>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& p) { return starts_with(text, p); });
}

/// What every room of stages may include, and `more`.
std::vector<std::string> stage_folder(std::vector<std::string> more) {
  more.insert(more.end(), {"fsw/shared/", "fsw/base/", "fsw/records/", "fsw/executive/component.hpp",
                           "fsw/executive/event_log.hpp", "fsw/executive/stage_component.hpp", "cfg/",
                           "hal/camera/camera.hpp", "hal/clock/clock.hpp", "hal/store/store.hpp",
                           "hal/store/store_view.hpp", "hal/store/forwarding_store.hpp", "hal/store/newest_id.hpp"});
  return more;
}

/// What every room of host programs may include, and `more`.
std::vector<std::string> host(std::vector<std::string> more) {
  more.insert(more.end(), {"sim/host/", "fsw/", "hal/", "cfg/"});
  return more;
}

/// What a room of `fsw/vision` may include: `rooms` of it, given by their paths below `fsw/vision`.
std::vector<std::string> kernels(std::vector<std::string> folders) {
  for (std::string& path : folders) path = "fsw/vision/" + path;
  folders.insert(folders.end(), {"fsw/base/", "cfg/choices.hpp", "cfg/limits.hpp"});
  return folders;
}

// The arrows of the architecture: what a folder may include of ours, longest folder first.
const std::vector<std::pair<std::string, std::vector<std::string>>> allowed = {
    {"fsw/base/", {"fsw/base/"}},
    {"fsw/records/", {"fsw/records/", "fsw/base/", "cfg/limits.hpp", "cfg/choices.hpp"}},
    {"fsw/vision/", {"fsw/vision/", "fsw/base/", "cfg/choices.hpp", "cfg/limits.hpp"}},
    // Rooms of kernels: from the camera and the pixels upwards.
    {"fsw/vision/geometry/", kernels({"geometry/"})},
    {"fsw/vision/image/", kernels({"image/"})},
    {"fsw/vision/overlap/", kernels({"overlap/", "image/"})},
    {"fsw/vision/forecast/", kernels({"forecast/", "overlap/"})},
    {"fsw/vision/features/", kernels({"features/", "geometry/", "image/"})},
    {"fsw/vision/twoview/", kernels({"twoview/", "features/", "geometry/", "overlap/"})},
    {"fsw/vision/twoview/solvers/", kernels({"twoview/solvers/", "geometry/"})},
    {"fsw/vision/twoview/refine/", kernels({"twoview/refine/", "twoview/solvers/", "geometry/"})},
    {"fsw/vision/twoview/robust/", kernels({"twoview/robust/", "twoview/refine/", "twoview/solvers/", "geometry/"})},
    {"fsw/vision/multiview/",
     kernels({"multiview/", "twoview/", "features/feature_types.hpp", "geometry/", "image/small_solver.hpp"})},
    {"fsw/vision/multiview/bundle/", kernels({"multiview/bundle/", "geometry/"})},
    {"fsw/vision/calibration/",
     kernels({"calibration/", "multiview/", "twoview/", "features/feature_types.hpp", "geometry/"})},
    {"fsw/vision/stereo/", kernels({"stereo/", "geometry/"})},
    {"fsw/vision/stereo/rectify/",
     kernels({"stereo/rectify/", "stereo/disparity_map.hpp", "stereo/disparity_range.hpp", "geometry/"})},
    {"fsw/vision/stereo/cost/", kernels({"stereo/cost/", "stereo/disparity_range.hpp", "stereo/stereo_params.hpp"})},
    {"fsw/vision/stereo/semi_global/", kernels({"stereo/semi_global/", "stereo/cost/"})},
    {"fsw/vision/stereo/ordered/", kernels({"stereo/ordered/", "stereo/cost/"})},
    {"fsw/vision/stereo/match/",
     kernels({"stereo/match/", "stereo/ordered/", "stereo/semi_global/", "stereo/cost/", "stereo/disparity_map.hpp",
              "stereo/disparity_range.hpp", "stereo/stereo_params.hpp"})},
    {"fsw/vision/stereo/depth/",
     kernels({"stereo/depth/", "stereo/rectify/", "stereo/disparity_map.hpp", "geometry/"})},
    {"fsw/vision/place/", kernels({"place/", "features/", "image/", "overlap/"})},
    {"fsw/vision/terrain/", kernels({"terrain/", "stereo/depth/", "geometry/"})},
    {"fsw/vision/codec/", kernels({"codec/"})},
    {"fsw/vision/navigation/", kernels({"navigation/", "geometry/"})},
    // The files of maps, for the flight and for the ground that writes them.
    {"fsw/maps/",
     {"fsw/maps/", "fsw/vision/codec/", "fsw/vision/place/", "fsw/vision/terrain/bit_coder.hpp",
      "fsw/vision/terrain/mask_coding.hpp", "fsw/packets/hmac_sha256.hpp", "fsw/shared/body_figure.hpp", "fsw/base/",
      "cfg/choices.hpp", "cfg/limits.hpp"}},
    {"fsw/vision/map/", kernels({"map/", "geometry/", "image/"})},
    {"fsw/packets/",
     {"fsw/packets/", "fsw/base/", "fsw/records/", "cfg/choices.hpp", "cfg/limits.hpp", "cfg/mission.hpp",
      "cfg/schedule.hpp", "hal/clock/clock.hpp", "hal/link/packet_link.hpp"}},
    {"fsw/executive/",
     {"fsw/executive/", "fsw/base/", "fsw/records/", "cfg/", "hal/clock/clock.hpp", "hal/store/store.hpp",
      "hal/store/store_view.hpp", "hal/store/forwarding_store.hpp", "hal/store/newest_id.hpp"}},
    // Rooms of stages: none knows another one, but those that talk to the ground, from the packets upwards.
    {"fsw/shared/", stage_folder({"fsw/vision/multiview/sequence.hpp", "fsw/vision/geometry/rigid_transform.hpp",
                                  "fsw/vision/geometry/rolling_shutter.hpp", "fsw/vision/navigation/strip_frame.hpp",
                                  "fsw/packets/authentication.hpp", "hal/nonvolatile/nonvolatile.hpp"})},
    {"fsw/imaging/", stage_folder({"fsw/imaging/", "fsw/vision/", "hal/compute/compute.hpp"})},
    {"fsw/motion/", stage_folder({"fsw/motion/", "fsw/vision/"})},
    {"fsw/terrain/", stage_folder({"fsw/terrain/", "fsw/vision/", "hal/compute/compute.hpp"})},
    {"fsw/products/",
     stage_folder({"fsw/products/", "fsw/vision/", "hal/worker/worker.hpp", "hal/worker/inline_worker.hpp"})},
    {"fsw/storage/",
     stage_folder({"fsw/storage/", "fsw/vision/codec/", "fsw/vision/overlap/overlap.hpp", "hal/store/scrub.hpp"})},
    {"fsw/downlink/", stage_folder({"fsw/downlink/", "fsw/maps/", "fsw/vision/codec/", "fsw/packets/",
                                    "hal/link/link.hpp", "hal/maps/map_source.hpp"})},
    {"fsw/commanding/", stage_folder({"fsw/commanding/", "fsw/downlink/", "fsw/packets/"})},
    {"fsw/navigation/", stage_folder({"fsw/navigation/", "fsw/packets/", "fsw/vision/", "hal/link/packet_link.hpp",
                                      "hal/navigation/navigation.hpp"})},
    {"fsw/localisation/", stage_folder({"fsw/localisation/", "fsw/maps/", "fsw/vision/", "hal/maps/map_source.hpp"})},
    {"fsw/telemetry/", stage_folder({"fsw/telemetry/", "fsw/downlink/", "fsw/packets/"})},
    // profile.hpp is that of the build's profile.
    {"cfg/", {"cfg/", "fsw/base/", "fsw/records/field.hpp", "profile.hpp"}},
    {"hal/", {"hal/", "fsw/base/", "fsw/records/", "cfg/limits.hpp"}},
    // commit.inc is written by the build.
    {"bsp/", {"bsp/", "fsw/", "hal/", "cfg/", "commit.inc"}},
    {"sim/", {"sim/", "bsp/", "fsw/", "hal/", "cfg/"}},
    // Host programs: the simulator and the ground do not know each other, tools know both.
    {"sim/host/", host({"bsp/flight/mission_file.hpp", "bsp/flight/nearest_word.hpp", "bsp/flight/status_text.hpp",
                        "bsp/version/"})},
    {"sim/world/", host({"sim/world/"})},
    {"sim/sil/", host({"sim/sil/", "sim/world/", "bsp/"})},
    {"sim/ground/", host({"sim/ground/"})},
    {"sim/ground/intake/", host({"sim/ground/intake/"})},
    {"sim/ground/fixes/", host({"sim/ground/fixes/", "sim/ground/model/", "sim/ground/intake/"})},
    {"sim/ground/model/", host({"sim/ground/model/", "sim/ground/intake/"})},
    {"sim/ground/map/", host({"sim/ground/map/", "sim/ground/intake/"})},
    {"sim/ground/export/", host({"sim/ground/export/", "sim/ground/map/", "sim/ground/intake/"})},
    {"sim/ground/control/", host({"sim/ground/control/", "sim/ground/intake/"})},
    {"sim/ground/landing/",
     host({"sim/ground/landing/", "sim/ground/control/", "sim/ground/export/", "sim/ground/map/"})},
    {"sim/ground/tasks/", host({"sim/ground/tasks/", "sim/ground/export/", "sim/ground/map/", "sim/ground/intake/"})},
    {"sim/ground/report/", host({"sim/ground/report/", "sim/ground/control/", "sim/ground/export/", "sim/ground/fixes/",
                                 "sim/ground/landing/", "sim/ground/map/", "sim/ground/model/", "sim/ground/intake/"})},
    {"sim/ground/compare/", host({"sim/ground/compare/", "sim/ground/report/", "sim/ground/map/"})},
    {"sim/ground/viewer/", host({"sim/ground/viewer/", "sim/ground/report/", "sim/ground/export/", "sim/ground/fixes/",
                                 "sim/ground/map/", "sim/ground/intake/"})},
    {"sim/ground/maps/", host({"sim/ground/maps/"})},
    {"sim/ground/cfdp/", host({"sim/ground/cfdp/"})},
    {"sim/ground/console/", host({"sim/ground/console/", "sim/ground/cfdp/"})},
    {"sim/ground/serve/", host({"sim/ground/"})},
    {"sim/board/", host({"sim/ground/console/", "bsp/"})},
    {"sim/tools/lab/",
     host({"sim/tools/lab/", "sim/ground/", "sim/world/", "sim/sil/flyable_images.hpp", "bsp/flight/"})},
    {"sim/tools/score/", host({"sim/tools/score/", "sim/ground/", "sim/world/"})},
    {"sim/tools/richness/", host({"sim/tools/richness/", "sim/ground/", "sim/world/"})},
    {"sim/tools/docgen/", host({"sim/tools/docgen/", "bsp/flight/status_text.hpp"})},
    {"sim/tools/gps/", host({"sim/tools/gps/"})},
    {"sim/tools/store/", host({"sim/tools/store/", "bsp/flight/stage_set.hpp"})},
};

// Headers of the C++ library that flight code may use: no heap, no streams, no threads, no operating system.
const std::set<std::string> flight_headers = {
    "algorithm", "array",    "bit",     "bitset",      "cfloat",  "climits",     "charconv", "cmath",
    "compare",   "concepts", "cstddef", "cstdint",     "cstring", "functional",  "iterator", "limits",
    "new",       "numeric",  "span",    "string_view", "tuple",   "type_traits", "utility"};

// The one place for each foreign header.
const std::vector<std::pair<std::string, std::string>> foreign = {
    {"Eigen/", "fsw/vision/"},
    {"openjpeg", "fsw/vision/codec/openjpeg_codec.cpp"},
    {"sqlite3.h", "hal/store/sqlite/"},
    {"jpeglib.h", "hal/camera/jpeg/grey_jpeg.cpp"},
    {"libpq-fe.h", "hal/store/postgres/"},
    {"vulkan/", "bsp/vulkan/"},
    {"sodium", "fsw/packets/hmac_sha256.cpp"},
    // OpenJPEG does not survive a failed malloc: the call is abandoned as a whole.
    {"csetjmp", "fsw/base/heap_gate.cpp"},
};

TEST(Tidy, IncludesFollowTheArrowsOfTheHouse) {
  for (const auto& [folder, targets] : allowed) {
    for (const std::string& file : sources_below(folder.substr(0, folder.size() - 1))) {
      for (const Include& include : includes_of(file)) {
        if (include.system) continue;
        EXPECT_TRUE(any_prefix(include.target, targets))
            << file << ":" << include.line << " includes " << include.target << ", which " << folder << " must not";
      }
    }
  }
}

TEST(Tidy, FlightCodeUsesNoHeapStreamOrSystemHeader) {
  for (const char* folder : {"fsw", "cfg"}) {
    for (const std::string& file : sources_below(folder)) {
      for (const Include& include : includes_of(file)) {
        if (!include.system || flight_headers.count(include.target) != 0) continue;
        // strtod: std::from_chars for a double is a part of the run time of C++, which the flight program does without.
        const bool reads_numbers = file == "cfg/mission_text.cpp" || file == "hal/navigation/csv/navigation_file.cpp";
        if (include.target == "cstdlib" && reads_numbers) continue;
        const bool granted = std::any_of(foreign.begin(), foreign.end(), [&](const auto& rule) {
          return starts_with(include.target, rule.first) && starts_with(file, rule.second);
        });
        EXPECT_TRUE(granted) << file << ":" << include.line << " includes <" << include.target << ">";
      }
    }
  }
}

TEST(Tidy, ForeignLibrariesAreIncludedInOnePlace) {
  for (const char* folder : {"fsw", "hal", "cfg", "bsp"}) {
    for (const std::string& file : sources_below(folder)) {
      for (const Include& include : includes_of(file)) {
        for (const auto& [header, place] : foreign) {
          if (!starts_with(include.target, header)) continue;
          EXPECT_TRUE(starts_with(file, place))
              << file << ":" << include.line << " includes <" << include.target << ">";
        }
      }
    }
  }
}

TEST(Tidy, FlightSourcesKeepToTheLanguageThatFlies) {
  static const std::vector<std::pair<std::regex, const char*>> banned = {
      {std::regex(R"(\b(try|catch|throw)\b)"), "exceptions"},
      {std::regex(R"(\b(dynamic_cast|typeid)\b)"), "run-time type information"},
      {std::regex(R"(\bstd::(vector|string|map|set|list|deque|function|unique_ptr|shared_ptr|unordered_\w+)\b)"),
       "a type that allocates"},
      {std::regex(R"(\b(malloc|calloc|realloc|free)\s*\()"), "the heap"},
      {std::regex(R"(\bstd::(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|log|log2|log10|pow|cbrt|hypot)\s*\()"),
       "libm, whose last bit depends on the machine: see fsw/base/math.hpp"},
      {std::regex(R"(\b(TODO|FIXME|XXX)\b)"), "an unfinished thought"},
  };
  for (const char* folder : {"fsw", "hal", "cfg"}) {
    for (const std::string& file : sources_below(folder)) {
      const std::vector<std::string> lines = lines_of(file);
      for (std::size_t i = 0; i < lines.size(); ++i) {
        const std::string code = lines[i].substr(0, lines[i].find("//"));
        if (code.find('"') != std::string::npos) continue;
        for (const auto& [pattern, what] : banned) {
          EXPECT_FALSE(std::regex_search(code, pattern))
              << file << ":" << i + 1 << " uses " << what << ": " << lines[i];
        }
      }
    }
  }
}

TEST(Tidy, RefusedArgumentsAreNamed) {
  // fsw/base/argument.hpp makes the Status.
  const std::string code = "StatusCode::invalid_argument";
  for (const char* const floor : {"fsw", "hal", "bsp", "cfg"}) {
    for (const std::string& file : sources_below(floor)) {
      if (file == "fsw/base/status.cpp") continue;
      const std::vector<std::string> lines = lines_of(file);
      for (std::size_t i = 0; i < lines.size(); ++i) {
        for (const char* const before : {"{", "return ", ": "})
          EXPECT_EQ(lines[i].find(before + code), std::string::npos) << file << ":" << i + 1 << ": " << lines[i];
      }
    }
  }
}

TEST(Tidy, LinesFitThePageAndFilesHoldOneIdea) {
  for (const char* folder : {"fsw", "hal", "cfg", "bsp", "sim", "tests"}) {
    for (const std::string& file : sources_below(folder)) {
      if (fs::path(file).extension() == ".inc") continue;
      const std::vector<std::string> lines = lines_of(file);
      EXPECT_LE(lines.size(), 700U) << file << " has grown past one idea";
      for (std::size_t i = 0; i < lines.size(); ++i) {
        EXPECT_LE(lines[i].size(), 140U) << file << ":" << i + 1;
      }
    }
  }
}

// Dumps and results of runs have been committed by mistake.
TEST(Tidy, OnlySourcesAreInTheRepository) {
  static const std::regex source(
      R"((.*\.(cpp|hpp|inc|txt|md|py|js|mjs|css|html|ini|json|cmake|comp|glsl|svg|sh|service|conf|cff)|docs/images/.*\.png|)"
      R"(sim/demo/.*\.jpg|tests/fuzz/corpus/.*|bsp/packages/.*|(.*/)?\.[^/]*|LICENSE))");
  std::istringstream files(output_of("git -C '" + root.string() + "' ls-files 2>/dev/null"));
  std::size_t seen = 0;
  for (std::string file; std::getline(files, file); ++seen) {
    if (std::regex_match(file, source)) continue;
    std::ifstream in(root / file);
    std::string first;
    std::getline(in, first);
    EXPECT_TRUE(starts_with(first, "#!"))
        << file << " is no source that the project knows: remove it, or name its kind here";
  }
  if (seen == 0) GTEST_SKIP() << "no git repository";
}

// Proof of "no heap, no exceptions, no RTTI" on what the compiler made of the flight libraries.
// After a flight that did not end in order, such a shell copies the log into the database, without checksums.
TEST(Tidy, NoPageRecommendsAShellOfSqliteThatMayWrite) {
  static const std::regex shell(R"(\bsqlite3\s)"), reads_only(R"(-readonly|mode=ro)");
  std::size_t pages = 0;
  for (const char* folder : {"docs", "bsp", "sim", "tests", "."}) {
    for (auto entry = fs::recursive_directory_iterator(root / folder); entry != fs::recursive_directory_iterator();
         ++entry) {
      // In the root only the pages themselves: builds lie there too.
      if (std::string(folder) == "." && entry->is_directory()) entry.disable_recursion_pending();
      if (entry->path().extension() != ".md") continue;
      ++pages;
      const std::vector<std::string> lines = lines_of(fs::relative(entry->path(), root).string());
      for (std::size_t i = 0; i < lines.size(); ++i) {
        if (!std::regex_search(lines[i], shell) || std::regex_search(lines[i], reads_only)) continue;
        ADD_FAILURE() << entry->path() << ":" << i + 1 << ": recommend ilp-store, or sqlite3 -readonly";
      }
    }
  }
  EXPECT_GT(pages, 30U);
}

TEST(Tidy, FlightLibrariesNameNoAllocatorAndNoUnwinder) {
  // Undefined symbols, demangled names avoided on purpose: new, delete, malloc's family, the unwinder, exceptions of
  // ours and of the library, RTTI.
  static const std::regex forbidden(
      "(_Zn[wa].*|_Zd[la]P.*|malloc|calloc|realloc|reallocarray|posix_memalign|aligned_alloc|memalign|strdup|strndup|"
      "free"
      "|_Unwind_.*|__cxa_[a-z_]*(throw|catch|exception|bad_)[a-z_]*|_ZSt[0-9]+__throw_.*|__gxx_personality_v0"
      "|__dynamic_cast|_ZTI.*|_ZTVN10__cxxabiv1.*)");
  std::ifstream list(ILP_FLIGHT_LIBRARIES);
  std::size_t libraries = 0;
  for (std::string library; std::getline(list, library);) {
    if (library.empty()) continue;
    ++libraries;
    std::istringstream lines(output_of(std::string(ILP_NM) + " '" + library + "' 2>/dev/null"));
    std::size_t seen = 0;
    for (std::string line; std::getline(lines, line);) {
      ++seen;
      const std::size_t at = line.find(" U ");
      if (at == std::string::npos) continue;
      const std::string symbol = line.substr(at + 3);
      EXPECT_FALSE(std::regex_match(symbol, forbidden)) << library << " names " << symbol;
    }
    EXPECT_GT(seen, 0U) << library << ": nm printed nothing";
  }
  EXPECT_GT(libraries, 8U);
}

}  // namespace
