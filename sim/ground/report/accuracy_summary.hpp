// Summarises the measured errors of a flight in a few numbers and lines. The errors of the delivered model come first;
// if the ground has joined strips, this is its model, and those of the flight's own poses follow.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// Unknown values are NaN.
struct AccuracySummary {
  double mean_percent = unknown, max_percent = unknown;  ///< position errors, % of the distance flown
  std::size_t poses = 0;
  double rotation_deg = unknown;    ///< mean attitude error
  double height_percent = unknown;  ///< error of the merged heights, % of the flying height; in a score only
  double depth_percent = unknown;   ///< error of the depths of all pixels, % of the flying height; in a score only
  /// Depth error over the keyframes, each by its median pixel, % of the flying height; without a score only.
  double keyframe_depth_percent = unknown;
};

/// Errors of the report's model against its reference.
[[nodiscard]] AccuracySummary measured_accuracy(const Report& report);
/// Errors of the downlinked flight by ilp-score.
[[nodiscard]] AccuracySummary scored_accuracy(const ScoreFile& score);

/// Whether the report's model differs from the flight's own, and has been measured.
[[nodiscard]] bool model_is_measured(const Report& report);

/// Lines about the errors against the reference: first of the joined model, then of the score.
[[nodiscard]] std::vector<std::string> accuracy_lines(const Report& report);

/// Text of the components of a height error, each multiplied by `factor`; "not known" for an unknown one.
[[nodiscard]] std::string parts_text(const map::HeightErrorParts& parts, double factor);

/// Lines about the estimated errors of heights, scale and position, or about what is missing for metres: one for each
/// of the first strips with a map.
[[nodiscard]] std::vector<std::string> estimated_error_lines(const Report& report);

/// Lines that say why nothing is mapped, and what to do; empty if anything is mapped.
[[nodiscard]] std::vector<std::string> nothing_lines(const Report& report);

}  // namespace ilp::report
