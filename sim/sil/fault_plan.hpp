// What goes wrong in a simulated flight. Everything is off by default, and each fault works alone.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/time.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::sil {

/// Shares are chances of each frame, 0 to 1. A window begins `from`, lasts `for` (0: never) and comes again `every` so
/// many seconds (0: once).
struct FaultPlan {
  double lost_share = 0;
  double duplicated_share = 0;
  double late_share = 0;  ///< the frames after a late one overtake it
  double late_by_s = 6;
  double misstamped_share = 0;
  double misstamped_by_s = 60;  ///< negative: backwards
  double black_share = 0;
  double saturated_share = 0;
  double blurred_share = 0;
  int blur_radius_px = 8;  ///< of a box, applied twice

  double dead_from_s = 0;  ///< by the frames' own times
  double dead_for_s = 0;
  double dead_every_s = 0;

  double store_full_from_s = 0;
  double store_full_for_s = 0;
  double store_full_every_s = 0;

  double link_outage_from_s = 0;
  double link_outage_for_s = 0;
  double link_outage_every_s = 0;

  double power_cut_after_s = 0;  ///< 0: never; the flight goes on by itself
  int power_cuts = 0;            ///< at random instants, also within a transaction; the flight goes on by itself
};

[[nodiscard]] std::vector<world::Parameter> parameters(FaultPlan& plan);

/// Rounds to the nearest nanosecond.
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

/// Whether a fault of this kind strikes this frame. The answer does not depend on the order of calls or on restarts.
[[nodiscard]] bool strikes(std::uint64_t seed, const char* kind, std::int64_t sequence, double share);

}  // namespace ilp::sil
