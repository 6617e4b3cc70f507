// The errors that a reader wants first: those of what is delivered. Where the ground has joined strips, that is its
// model; the poses that the flight sent come second.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// Unknown values are NaN.
struct AccuracySummary {
  double mean_percent = unknown, max_percent = unknown;  ///< of positions, of the distance flown
  std::size_t poses = 0;
  double rotation_deg = unknown;            ///< mean
  double height_percent = unknown;          ///< of the merged heights, of the flying height; in a score only
  double depth_percent = unknown;           ///< of the depths of all pixels, of the flying height; in a score only
  double keyframe_depth_percent = unknown;  ///< of the keyframes, each by its median pixel; without a score only
};

/// Of the maps and poses of the report, against its reference.
[[nodiscard]] AccuracySummary measured_accuracy(const Report& report);
/// Of the flight as it was sent, by ilp-score.
[[nodiscard]] AccuracySummary scored_accuracy(const ScoreFile& score);

/// Whether the model of the report is another one than the flight's own, and is measured.
[[nodiscard]] bool model_is_measured(const Report& report);

/// Errors against the reference, a line each: the joined model's first, then those of the score.
[[nodiscard]] std::vector<std::string> accuracy_lines(const Report& report);

/// The parts of the error of a height, each times `factor`; "not known" where nothing is stated.
[[nodiscard]] std::string parts_text(const map::HeightErrorParts& parts, double factor);

/// How certain heights, scale and place are by what the flight states, or what is missing for metres; a line for each
/// strip with a map.
[[nodiscard]] std::vector<std::string> estimated_error_lines(const Report& report);

/// Why nothing is mapped, and what to do; empty where anything is.
[[nodiscard]] std::vector<std::string> nothing_lines(const Report& report);

}  // namespace ilp::report
