// Finds out whether the ground of a map repeats itself. A keyframe that was found by heights alone may be at any of the
// repetitions, even at one outside the search range.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/vision/map/map_plan.hpp"
#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Compares the heights around a keyframe with those of the rest of its window, in slices of about 6 million
/// multiplications. Each patch is searched for outside its own position, and patches that agree on a shift are votes
/// for it. A shift counts only if at least six patches stay inside the window.
class RepeatSearch {
 public:
  /// `plan.sheet_column` and `plan.sheet_row` are the position of the keyframe in the window. Overwrites the workspace.
  void begin(const MapWindow& window, double level_m, const MapPlan& plan, MapRegistrationWorkspace& workspace);
  /// Does one slice. Returns false if the result is complete.
  bool step(MapRegistrationWorkspace& workspace);
  /// True if the ground repeats itself. The evidence for ground that does not has reached 8.
  [[nodiscard]] bool repeats() const { return evidence_ >= least_repeat_evidence; }
  /// The highest vote_evidence() of all shifts.
  [[nodiscard]] double evidence() const { return evidence_; }

  static constexpr double least_repeat_evidence = 10;

 private:
  void count(const MapRegistrationWorkspace& workspace);

  std::int32_t column_ = 0, row_ = 0;  ///< position of the keyframe's ground in the window, reduced px
  std::int32_t patches_ = 0, patch_ = 0;
  double evidence_ = 0;
};

}  // namespace ilp
