// score.json, as ilp-score writes it, for the report.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "sim/host/raster.hpp"

namespace ilp::report {

/// Unknown values are NaN; lengths are in the truth's unit.
struct ScoredKeyframe {
  std::int64_t id = 0;
  double distance = unknown;
  double position_error = unknown, height_error = unknown, drift_error = unknown, local_scale = unknown;
  std::optional<Vec3> true_centre, aligned_centre;
  std::optional<Vec3> sigma, relative_error;
  double overlap = unknown, true_overlap = unknown;
};

struct ScoredStrip {
  std::int64_t id = 0;
  double length = unknown, flying_height = unknown;
  double position_mean_percent = unknown, position_max_percent = unknown;
  double drift_percent = unknown, scale_drift_percent = unknown, bow_percent = unknown;
  std::optional<Vec3> bow_fit;                           ///< a, b, c of a + b u + c u^2, u = 2 distance / length - 1
  std::optional<Vec3> up, forward;                       ///< in the truth's world
  std::vector<ScoredKeyframe> keyframes;                 ///< those with a true centre, in order
  std::vector<std::pair<double, double>> surface_error;  ///< distance and median height error of the merged map
};

struct ScoreFile {
  bool complete = false;
  double target_overlap = unknown;
  std::map<std::string, double> summary;
  std::vector<ScoredStrip> strips;
  std::vector<ScoredKeyframe> keyframes;  ///< all
  std::vector<std::string> remarks;
  host::Raster<float> height_error;  ///< of height-error.pfm beside it, NaN where not compared; empty without that file
};

/// std::runtime_error when the file is no score, or one of another version.
[[nodiscard]] ScoreFile read_score(const std::filesystem::path& path);

// The numbers of a score that a person wants first.

/// Positions, heights and estimated errors, a line each; what was not measured is left out, an incomplete flight said.
[[nodiscard]] std::vector<std::string> score_lines(const ScoreFile& score);

}  // namespace ilp::report
