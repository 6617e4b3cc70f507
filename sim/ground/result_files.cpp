#include "sim/ground/result_files.hpp"

#include <regex>
#include <system_error>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/host/files.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

constexpr const char* pages[] = {"report.json", "report.html", "viewer.html"};

void add_pictures(const intake::Keyframe& keyframe, std::vector<std::string>& files) {
  const std::string base = "keyframes/" + host::six_digits(keyframe.id);
  if (keyframe.has_image()) files.push_back(base + "-image.png");
  if (keyframe.has_mask()) files.push_back(base + "-mask.png");
  if (!keyframe.has_depth()) return;
  files.push_back(base + "-depth.png");
  files.push_back(base + "-depth.pfm");
}

void add_colmap(const report::StripResult& strip, std::vector<std::string>& files) {
  if (strip.colmap.images == 0) return;
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    files.push_back("colmap" + strip.suffix + "/" + name);
  }
}

std::vector<std::string> matching(const fs::path& folder, const std::string& prefix, const std::regex& pattern) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder / prefix, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (std::regex_match(name, pattern)) names.push_back(prefix + name);
  }
  return names;
}

/// Everything in the folder that carries one of this program's names.
std::vector<std::string> named_like_results(const fs::path& folder) {
  static const std::regex results(
      R"(report\.(json|html)|viewer\.html|(keyframes|events|navigation|strip-frames|housekeeping-\w+)\.csv|)"
      R"((model|points)(-strip-\d+)?\.(ply|glb)|(track|footprints)(-strip-\d+)?\.geojson|)"
      R"((height|sigma|sigma-matching|ortho|laid|count|colour)(-strip-\d+)?\.(tif|pfm|png|pgw)|)"
      R"(landing-(safe|slope|roughness|step|sites)(-strip-\d+)?\.(tif|geojson))");
  static const std::regex pictures(R"(\d{6,}-(image|mask|depth)\.(png|pfm))");
  static const std::regex models(R"(colmap(-strip-\d+)?)");
  std::vector<std::string> names = matching(folder, "", results);
  for (std::string& name : matching(folder, "keyframes/", pictures)) names.push_back(std::move(name));
  for (const std::string& model : matching(folder, "", models)) {
    for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) names.push_back(model + "/" + name);
  }
  return names;
}

}  // namespace

bool is_copy(const std::string& name) {
  return name == intake::catalogue_name || name.ends_with(".pfm") ||
         (name.starts_with("model") && name.ends_with(".ply"));
}

std::vector<std::string> map_files(const report::StripResult& strip) {
  if (!strip.grid) return {};
  std::vector<std::string> files = strip.map_files;
  for (const char* name : {"height", "sigma"}) files.push_back(name + strip.suffix + ".pfm");
  for (const char* ending : {".png", ".pgw"}) files.push_back("ortho" + strip.suffix + ending);
  files.push_back("count" + strip.suffix + ".png");
  return files;
}

std::vector<std::string> result_files(const report::Report& report) {
  std::vector<std::string> files{intake::catalogue_name, pages[0], pages[1]};
  if (report.has_viewer) files.emplace_back(pages[2]);
  files.insert(files.end(), report.tables.begin(), report.tables.end());
  for (const auto& [id, keyframe] : report.flight.keyframes) add_pictures(keyframe, files);
  for (const report::StripResult& strip : report.strips) {
    files.insert(files.end(), strip.files.begin(), strip.files.end());
    for (std::string& name : map_files(strip)) files.push_back(std::move(name));
    add_colmap(strip, files);
  }
  if (!report.with_copies) std::erase_if(files, is_copy);
  return files;
}

void remove_pages(const fs::path& folder) {
  std::error_code ignored;
  for (const char* page : pages) fs::remove(folder / page, ignored);
}

void remove_other_results(const fs::path& folder, const std::vector<std::string>& files, const RunRecord& before) {
  const std::set<std::string> kept(files.begin(), files.end());
  std::vector<std::string> others = named_like_results(folder);
  for (const auto& [name, file] : before.files) others.push_back(name);
  for (const std::string& name : others) {
    if (kept.contains(name)) continue;
    std::error_code ignored;
    fs::remove(folder / name, ignored);
    // A folder of ours stays when something else lies in it.
    if (name.starts_with("colmap")) fs::remove((folder / name).parent_path(), ignored);
  }
}

}  // namespace ilp::ground
