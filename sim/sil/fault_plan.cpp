#include "sim/sil/fault_plan.hpp"

#include <cmath>

#include "fsw/base/rng.hpp"

namespace ilp::sil {
namespace {

constexpr double longest_s = 1e7;

std::uint64_t hash_text(const char* text) {
  // FNV-1a.
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (; *text != 0; ++text) hash = (hash ^ static_cast<unsigned char>(*text)) * 0x100000001B3ULL;
  return hash;
}

}  // namespace

TimeNs nanoseconds(double seconds) {
  return static_cast<TimeNs>(std::floor(seconds * static_cast<double>(ns_per_s) + 0.5));
}

std::vector<world::Parameter> parameters(FaultPlan& p) {
  return {
      {"lost_share", &p.lost_share, "", "share of frames that never arrive", 0, 1},
      {"duplicated_share", &p.duplicated_share, "", "share of frames that arrive twice", 0, 1},
      {"late_share", &p.late_share, "", "share of frames that arrive late, after their successors", 0, 1},
      {"late_by_s", &p.late_by_s, "s", "delay of a late frame", 0, 3600},
      {"misstamped_share", &p.misstamped_share, "", "share of frames with a wrong time", 0, 1},
      {"misstamped_by_s", &p.misstamped_by_s, "s", "error of a wrong time; negative: earlier than the true time",
       -longest_s, longest_s},
      {"black_share", &p.black_share, "", "share of frames that are black", 0, 1},
      {"saturated_share", &p.saturated_share, "", "share of frames that are white", 0, 1},
      {"blurred_share", &p.blurred_share, "", "share of frames that are out of focus", 0, 1},
      {"blur_radius_px", &p.blur_radius_px, "px", "half width of the box that blurs, applied twice", 1, 100},
      {"dead_from_s", &p.dead_from_s, "s", "time from which the camera gives no frame", 0, longest_s},
      {"dead_for_s", &p.dead_for_s, "s", "length of the camera's silence; 0: none", 0, longest_s},
      {"dead_every_s", &p.dead_every_s, "s", "time after which the silence begins again; 0: it comes once", 0,
       longest_s},
      {"store_full_from_s", &p.store_full_from_s, "s", "time from which the store is full", 0, longest_s},
      {"store_full_for_s", &p.store_full_for_s, "s", "time for which the store is full; 0: never", 0, longest_s},
      {"store_full_every_s", &p.store_full_every_s, "s", "time after which it is full again; 0: it is full once", 0,
       longest_s},
      {"link_outage_from_s", &p.link_outage_from_s, "s", "time from which there is no contact with the ground", 0,
       longest_s},
      {"link_outage_for_s", &p.link_outage_for_s, "s", "length of the outage; 0: none", 0, longest_s},
      {"link_outage_every_s", &p.link_outage_every_s, "s", "time after which the outage begins again; 0: it comes once",
       0, longest_s},
      {"power_cut_after_s", &p.power_cut_after_s, "s", "time at which the power fails; 0: never", 0, longest_s},
      {"power_cuts", &p.power_cuts, "", "number of power failures at random instants", 0, 1000},
  };
}

bool inside_window(TimeNs time, const FaultWindow& window) {
  const TimeNs length = nanoseconds(window.for_s);
  const TimeNs period = nanoseconds(window.every_s);
  TimeNs since = time - nanoseconds(window.from_s);
  if (since < 0) return false;
  if (period > 0) since %= period;
  return since < length;
}

bool strikes(std::uint64_t seed, const char* kind, std::int64_t sequence, double share) {
  const std::uint64_t mixed = mix64(mix64(seed ^ hash_text(kind)) + static_cast<std::uint64_t>(sequence));
  return static_cast<double>(mixed >> 11U) * 0x1p-53 < share;
}

}  // namespace ilp::sil
