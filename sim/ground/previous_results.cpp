#include "sim/ground/previous_results.hpp"

#include <charconv>
#include <regex>
#include <string>
#include <system_error>
#include <vector>

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::vector<fs::path> matching(const fs::path& folder, const std::regex& pattern) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (std::regex_match(it->path().filename().string(), pattern)) paths.push_back(it->path());
  }
  return paths;
}

/// Whether the file belongs to a keyframe of the flight that has such a picture.
bool belongs(const std::string& name, const std::regex& pattern, const intake::Flight& flight) {
  std::smatch parts;
  if (!std::regex_match(name, parts, pattern)) return true;
  std::int64_t id = 0;
  const std::string digits = parts[1];
  if (std::from_chars(digits.data(), digits.data() + digits.size(), id).ec != std::errc()) return false;
  const auto keyframe = flight.keyframes.find(id);
  if (keyframe == flight.keyframes.end()) return false;
  if (parts[2] == "image") return keyframe->second.has_image();
  return parts[2] == "mask" ? keyframe->second.has_mask() : keyframe->second.has_depth();
}

}  // namespace

void remove_previous_results(const fs::path& folder, const intake::Flight& flight) {
  static const std::regex results(
      R"(report\.(json|html)|viewer\.html|(keyframes|events|housekeeping-\w+)\.csv|(model|points)(-strip-\d+)?\.(ply|glb)|)"
      R"((track|footprints)(-strip-\d+)?\.geojson|(height|sigma|ortho|count)(-strip-\d+)?\.(tif|pfm|png|pgw))");
  static const std::regex pictures(R"((\d{6,})-(image|mask|depth)\.(png|pfm))");
  static const std::regex models(R"(colmap(-strip-\d+)?)");
  std::error_code ignored;
  for (const fs::path& path : matching(folder, results)) fs::remove(path, ignored);
  for (const fs::path& path : matching(folder / "keyframes", pictures)) {
    if (!belongs(path.filename().string(), pictures, flight)) fs::remove(path, ignored);
  }
  for (const fs::path& model : matching(folder, models)) {
    for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) fs::remove(model / name, ignored);
    fs::remove(model, ignored);  // stays when something else lies in it
  }
}

}  // namespace ilp::ground
