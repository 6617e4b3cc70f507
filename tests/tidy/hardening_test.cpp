// The hardening of bsp/cmake/IlpTargets.cmake, read back from what compiler and linker made of it: of this build, and
// of the flight computer's where there is one (preset aarch64).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tidy/output_of.hpp"

namespace {

using ilp::test::output_of;

namespace fs = std::filesystem;

std::string readelf(const std::string& what, const fs::path& file) {
  return output_of(std::string(ILP_READELF) + " --wide " + what + " '" + file.string() + "' 2>/dev/null");
}

std::size_t count(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), regex), std::sregex_iterator()));
}

/// What an archive, an object or a program names and does not define: without the versions of shared libraries.
std::set<std::string> names_of(const fs::path& file) {
  static const std::regex pattern(R"( [Uw] ([^@\s]+))");
  const std::string text = output_of(std::string(ILP_NM) + " '" + file.string() + "' 2>/dev/null");
  std::set<std::string> names;
  for (auto i = std::sregex_iterator(text.begin(), text.end(), pattern); i != std::sregex_iterator(); ++i) {
    names.insert((*i)[1]);
  }
  return names;
}

/// The C library's calls in the form that knows how long its buffers are.
std::set<std::string> checked_calls(const std::set<std::string>& names) {
  static const std::regex pattern("__[a-z0-9]+_chk");
  std::set<std::string> calls;
  for (const std::string& name : names) {
    if (std::regex_match(name, pattern)) calls.insert(name);
  }
  return calls;
}

std::vector<fs::path> list_in(const fs::path& file) {
  std::ifstream in(file);
  std::vector<fs::path> paths;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) paths.emplace_back(line);
  }
  return paths;
}

struct Build {
  fs::path folder;
  std::vector<const char*> programs;
};

Build host_build() {
  Build build{ILP_BUILD_DIR, {"ilp-sil", "ilp-ground"}};
#ifndef ILP_SANITIZED
  build.programs.push_back("ilp-onboard");
  build.programs.push_back("ilp-camera-check");
#endif
  return build;
}
Build flight_computer() {
  return {fs::path(ILP_SOURCE_DIR) / "build" / "aarch64", {"ilp-onboard", "ilp-camera-check"}};
}

class Hardening : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static bool on_flight_computer() { return GetParam(); }
  void SetUp() override {
    build = on_flight_computer() ? flight_computer() : host_build();
    for (const char* name : build.programs) {
      const fs::path program = build.folder / "bin" / name;
      if (on_flight_computer() && !fs::exists(program)) {
        GTEST_SKIP() << program.string() << " is not there: cmake --preset aarch64 && cmake --build --preset aarch64";
      }
      ASSERT_TRUE(fs::exists(program)) << program;
      programs.push_back(program);
    }
    libraries = list_in(build.folder / "flight-libraries.txt");
    ASSERT_GT(libraries.size(), 8U) << build.folder;
  }

  Build build;
  std::vector<fs::path> programs;
  std::vector<fs::path> libraries;
};
INSTANTIATE_TEST_SUITE_P(Builds, Hardening, testing::Bool(),
                         [](const auto& test) { return test.param ? "flight_computer" : "host"; });

TEST_P(Hardening, ProgramsLieAnywhereInMemory) {
  for (const fs::path& program : programs) {
    EXPECT_EQ(count(readelf("--file-header", program), R"(Type:\s+DYN )"), 1U) << program;
    const std::string dynamic = readelf("--dynamic", program);
    EXPECT_EQ(count(dynamic, R"(\(FLAGS_1\).*\bPIE\b)"), 1U) << program;
    EXPECT_EQ(count(dynamic, "TEXTREL"), 0U) << program << " has code that the loader writes to";
    // A program of the board needs nothing but itself.
    EXPECT_EQ(count(readelf("--segments", program), "INTERP") == 0, on_flight_computer()) << program;
  }
}

TEST_P(Hardening, AddressesOfLibraryCallsAreBoundAtTheStartAndThenOnlyRead) {
  for (const fs::path& program : programs) {
    EXPECT_EQ(count(readelf("--segments", program), "GNU_RELRO"), 1U) << program;
    EXPECT_EQ(count(readelf("--dynamic", program), R"(\(FLAGS_1\).*\bNOW\b)"), 1U) << program;
  }
}

TEST_P(Hardening, WhatCanBeWrittenIsNeverExecuted) {
  for (const fs::path& program : programs) {
    const std::string segments = readelf("--segments", program);
    EXPECT_EQ(count(segments, R"(GNU_STACK\s+(0x[0-9a-f]+\s+){5}RW\s)"), 1U) << program << "\n" << segments;
    EXPECT_EQ(count(segments, R"(\bRWE\b)"), 0U) << program << "\n" << segments;
  }
}

TEST_P(Hardening, FlightLibrariesWatchTheirStack) {
  // Tables of members, and images whose pixels are the caller's: no function there has an array.
  const std::set<std::string> without_arrays = {"libilp_build_version.a", "libilp_hal_camera_picture.a",
                                                "libilp_records.a", "libilp_vision_image.a",
                                                "libilp_vision_stereo_semi_global.a"};
  for (const fs::path& library : libraries) {
    if (without_arrays.count(library.filename().string()) != 0) continue;
    EXPECT_EQ(names_of(library).count("__stack_chk_fail"), 1U) << library;
  }
}

TEST_P(Hardening, FlightLibrariesMakeCheckedCallsOnly) {
#ifdef ILP_SANITIZED
  if (!on_flight_computer()) GTEST_SKIP() << "the sanitizers look at these calls themselves";
#endif
  std::set<std::string> checked;
  std::set<std::string> unchecked;
  for (const fs::path& library : libraries) {
    const std::set<std::string> names = names_of(library);
    for (const std::string& call : checked_calls(names)) checked.insert(call);
    // These have a checked form whatever the compiler knows of the buffers.
    for (const char* call : {"longjmp", "_longjmp", "siglongjmp", "printf", "fprintf", "vfprintf", "snprintf"}) {
      if (names.count(call) != 0) unchecked.insert(library.filename().string() + " names " + call);
    }
  }
  EXPECT_EQ(checked.count("__longjmp_chk"), 1U) << "fsw/base/heap_gate.cpp is built without _FORTIFY_SOURCE";
  EXPECT_EQ(unchecked, std::set<std::string>());
}

// Debian's libraries have no such marks, so that the program as a whole has none: what is signed are its return
// addresses.
TEST_P(Hardening, BranchesOfFlightLibrariesAreProtectedWhereTheProcessorCan) {
  for (const fs::path& library : libraries) {
    const std::string notes = readelf("--notes", library);
    const std::size_t objects = on_flight_computer() ? count(notes, "File: ") : 0;
    EXPECT_EQ(objects > 0, on_flight_computer()) << library;
    EXPECT_EQ(count(notes, "AArch64 feature: BTI, PAC"), objects) << library;
  }
}

#ifndef ILP_SANITIZED
// With the symbols of the flight libraries (tidy_test.cpp) the whole proof: no allocation, exception, type information
// or guarded static of C++ is left in the program. Allocators of C are OpenJPEG's and SQLite's, each in its arena.
TEST(FlightProgram, NamesNothingOfTheRunTimeOfCxx) {
  for (const char* program : {"ilp-onboard", "ilp-camera-check"}) {
    const std::set<std::string> names = names_of(fs::path(ILP_BUILD_DIR) / "bin" / program);
    EXPECT_GT(names.count("__libc_start_main"), 0U) << program;
    for (const std::string& name : names) {
      // Ends of static objects, which the C library calls.
      if (name == "__cxa_atexit" || name == "__cxa_finalize") continue;
      EXPECT_FALSE(std::regex_match(name, std::regex("(_Z|__cxa_|_Unwind_|__gxx_|__dynamic_cast).*")))
          << program << " names " << name;
    }
  }
}
#endif

TEST(HardeningOfHostCode, ContainersLookAtTheirIndices) {
  const auto looks = [](const fs::path& library) {
    const std::set<std::string> names = names_of(library);
    return std::any_of(names.begin(), names.end(),
                       [](const auto& name) { return name.find("__glibcxx_assert_fail") != std::string::npos; });
  };
  // One text in an array; strings alone, of which GCC 14 knows the indices; an array without indices.
  const std::set<std::string> without_containers = {"libilp_viewer_resource.a", "libilp_test_sockets.a",
                                                    "libilp_test_loopback.a"};
  std::size_t seen = 0;
  for (const fs::path& library : list_in(fs::path(ILP_BUILD_DIR) / "host-libraries.txt")) {
    // What this test does not need may not have been built.
    if (!fs::exists(library) || without_containers.count(library.filename().string()) != 0) continue;
    ++seen;
    EXPECT_TRUE(looks(library)) << library;
  }
  EXPECT_GT(seen, 8U);
  for (const fs::path& library : list_in(fs::path(ILP_BUILD_DIR) / "flight-libraries.txt")) {
    EXPECT_FALSE(looks(library)) << library << ": flight code has capacities and assertions of its own";
  }
}

}  // namespace
