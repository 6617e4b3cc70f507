#include "sim/ground/previous_results.hpp"

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

}  // namespace

void remove_previous_results(const fs::path& folder) {
  static const std::regex results(
      R"(report\.(json|html)|viewer\.html|model(-strip-\d+)?\.ply|(height|ortho|count)(-strip-\d+)?\.(pfm|png|pgw))");
  static const std::regex models(R"(colmap(-strip-\d+)?)");
  static const std::regex pictures(R"(\d{6,}-(image|mask|depth)\.(png|pfm))");
  std::error_code ignored;
  for (const fs::path& path : matching(folder, results)) fs::remove(path, ignored);
  for (const fs::path& path : matching(folder / "keyframes", pictures)) fs::remove(path, ignored);
  for (const fs::path& model : matching(folder, models)) {
    for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) fs::remove(model / name, ignored);
    fs::remove(model, ignored);  // stays when something else lies in it
  }
}

}  // namespace ilp::ground
