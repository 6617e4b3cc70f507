// Reads score.json, which ilp-score writes, for the report.
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
  double distance = unknown;  ///< distance flown
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
  std::optional<Vec3> up, forward;                       ///< directions in the truth's world
  std::vector<ScoredKeyframe> keyframes;                 ///< those with a true centre, in the order of the strip
  std::vector<std::pair<double, double>> surface_error;  ///< distance, and median height error of the merged map there
};

struct ScoreFile {
  bool complete = false;
  double target_overlap = unknown;
  std::map<std::string, double> summary;
  std::vector<ScoredStrip> strips;
  std::vector<ScoredKeyframe> keyframes;  ///< all keyframes
  std::vector<std::string> remarks;
  host::Raster<float> height_error;  ///< from height-error.pfm beside it; NaN: not compared; empty: no such file
};

/// Throws std::runtime_error if the file is no score, or has another version.
[[nodiscard]] ScoreFile read_score(const std::filesystem::path& path);

/// A line each for positions, heights and estimated errors, as far as they were measured. An incomplete flight is
/// mentioned.
[[nodiscard]] std::vector<std::string> score_lines(const ScoreFile& score);

}  // namespace ilp::report
