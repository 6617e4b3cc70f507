#include "sim/tools/score/score_run.hpp"

#include <cmath>
#include <ostream>
#include <system_error>

#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/tools/score/calibration_score.hpp"
#include "sim/tools/score/dense_json.hpp"
#include "sim/tools/score/score_json.hpp"

namespace ilp::score {
namespace {
namespace fs = std::filesystem;

DenseScore dense_score(const ScoreOptions& options, const FlightFiles& files) {
  DenseOptions dense;
  dense.target_overlap = files.target_overlap;
  if (options.reference.empty()) dense.truth = truth_folder(options);
  std::error_code error;
  if (fs::is_directory(options.flight / "flight" / "images", error))
    dense.images = options.flight / "flight" / "images";
  // Images that were rendered for many flights lie beside their truth.
  const fs::path beside = truth_folder(options).parent_path() / "images";
  if (dense.images.empty() && options.reference.empty() && fs::is_directory(beside, error)) dense.images = beside;
  return score_dense(files.flight, *files.reference, dense);
}

// All strips lie on the grid of the true heights; where two overlap, the first stands.
void write_height_errors(const DenseScore& dense, const fs::path& path) {
  host::Raster<float> map;
  for (const auto& [id, strip] : dense.strips) {
    if (!strip.height || strip.height->error_map.empty()) continue;
    const host::Raster<float>& errors = strip.height->error_map;
    if (map.samples.empty()) map = host::Raster<float>(errors.width, errors.height, std::nanf(""));
    for (std::size_t i = 0; i < map.samples.size(); ++i) {
      if (std::isnan(map.samples[i])) map.samples[i] = errors.samples[i];
    }
  }
  std::error_code ignored;
  fs::remove(path, ignored);
  if (!map.samples.empty()) host::write_pfm(path, map.view());
}

}  // namespace

void run_score(const ScoreOptions& options, const fs::path& out, std::ostream& table) {
  const FlightFiles files = open_flight(options);
  Score score = score_poses_of(files);
  const DenseScore dense = dense_score(options, files);
  score.remarks.insert(score.remarks.end(), dense.remarks.begin(), dense.remarks.end());
  std::map<std::string, double> summary = summary_of(score);
  summary.merge(dense_summary(dense));
  double bytes = 0;
  for (const intake::ReceivedFile& file : files.outbox.files) bytes += static_cast<double>(file.bytes);
  summary["received_mb"] = 1e-6 * bytes;
  summary.merge(
      calibration_summary(files.flight, options.reference.empty() ? true_camera(truth_folder(options)) : std::nullopt));
  nlohmann::ordered_json json = score_json(score, files);
  json["summary"] = summary_json(summary);
  json["dense"] = dense_json(dense);
  const fs::path path = out.empty() ? options.flight / "score.json" : out;
  // Names from damaged files need not be UTF-8.
  host::write_file(path, json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  write_height_errors(dense, path.parent_path() / "height-error.pfm");
  write_table(score, summary, table);
  table << "score: " << path.string() << "\n";
}

}  // namespace ilp::score
