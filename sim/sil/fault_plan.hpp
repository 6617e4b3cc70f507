// The faults to inject into a simulated flight. All are off by default, and each works without the others.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/time.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::sil {

/// A share is the probability of the fault for each frame, 0 to 1. A window begins at `from`, lasts `for` seconds (0:
/// never) and repeats with the period `every` in seconds (0: once). All times are mission time.
struct FaultPlan {
  double lost_share = 0;
  double duplicated_share = 0;
  double late_share = 0;  ///< frames delivered after their successors
  double late_by_s = 6;
  double misstamped_share = 0;  ///< frames with a wrong time
  double misstamped_by_s = 60;  ///< negative: earlier than the true time
  double black_share = 0;
  double saturated_share = 0;
  double blurred_share = 0;
  int blur_radius_px = 8;  ///< half width of a box filter, applied twice

  double dead_from_s = 0;  ///< the camera gives no frames; compared with the times of the frames
  double dead_for_s = 0;
  double dead_every_s = 0;

  double store_full_from_s = 0;
  double store_full_for_s = 0;
  double store_full_every_s = 0;

  double link_outage_from_s = 0;
  double link_outage_for_s = 0;
  double link_outage_every_s = 0;

  double power_cut_after_s = 0;  ///< 0: never; the flight resumes without help
  int power_cuts = 0;  ///< number, at random instants and also within transactions; the flight resumes without help
};

/// The fields of the plan by name, for the section [faults] of scenario files.
[[nodiscard]] std::vector<world::Parameter> parameters(FaultPlan& plan);

/// Seconds as nanoseconds, rounded to the nearest.
[[nodiscard]] TimeNs nanoseconds(double seconds);

struct FaultWindow {
  double from_s = 0, for_s = 0, every_s = 0;
};
[[nodiscard]] inline FaultWindow camera_dead(const FaultPlan& plan) {
  return {plan.dead_from_s, plan.dead_for_s, plan.dead_every_s};
}
[[nodiscard]] inline FaultWindow store_full(const FaultPlan& plan) {
  return {plan.store_full_from_s, plan.store_full_for_s, plan.store_full_every_s};
}
[[nodiscard]] inline FaultWindow link_outage(const FaultPlan& plan) {
  return {plan.link_outage_from_s, plan.link_outage_for_s, plan.link_outage_every_s};
}
[[nodiscard]] bool inside_window(TimeNs time, const FaultWindow& window);

/// Whether a fault of this kind, with the probability `share`, strikes the frame with this sequence number. The answer
/// depends on the arguments only.
[[nodiscard]] bool strikes(std::uint64_t seed, const char* kind, std::int64_t sequence, double share);

}  // namespace ilp::sil
