// Whether the ground of a map repeats itself: a keyframe that was found by heights alone may stand at any of the
// repetitions, and those that the search does not reach count as well.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/vision/map/map_plan.hpp"
#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Compares the heights of the ground about a keyframe with all others of its window, in slices of at most some 6
/// million multiplications. Patches of them are sought elsewhere, and those that agree on one shift are votes for it. A
/// shift counts where six patches or more have ground of the window there: to two thirds of the image.
class RepeatSearch {
 public:
  /// `plan.sheet_column` and `sheet_row` are where the keyframe stands in the window. Uses all of the workspace.
  void begin(const MapWindow& window, double level_m, const MapPlan& plan, MapRegistrationWorkspace& workspace);
  /// One slice. False when the result is there.
  bool step(MapRegistrationWorkspace& workspace);
  /// Ground that does not repeat itself has had evidence up to 8.
  [[nodiscard]] bool repeats() const { return evidence_ >= least_repeat_evidence; }
  /// Of the shift with most, as vote_evidence().
  [[nodiscard]] double evidence() const { return evidence_; }

  static constexpr double least_repeat_evidence = 10;

 private:
  void count(const MapRegistrationWorkspace& workspace);

  std::int32_t column_ = 0, row_ = 0;  ///< of the keyframe's ground in the window, reduced px
  std::int32_t patches_ = 0, patch_ = 0;
  double evidence_ = 0;
};

}  // namespace ilp
