// What the fixes of a flight say: which keyframes stand on the map, and how far they would have been off without it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::fixes {

/// One-sigma ellipse of the ground point, without the error of the map's own place.
struct ErrorEllipse {
  double major_m = 0, minor_m = 0;
  double direction_rad = 0;  ///< of the long axis, from x towards y
};
[[nodiscard]] ErrorEllipse ellipse_of(const FixRecord& fix);

/// A keyframe with a fix record. Places are those of its ground point on the map; distances are horizontal, m.
struct KeyframeFix {
  FixRecord fix;
  std::optional<double> off_by_vehicle_m;  ///< from where the vehicle's measurements of the whole strip put it
  std::optional<double> off_by_first_m;    ///< from where the strip's first fixes and the poses since lead
  double off_by_first_sigma_m = 0;         ///< what the errors of those fixes explain of it
  std::optional<double> off_by_all_m;      ///< from where all fixes of the strip put it: what a similarity leaves
};

struct StripFixes {
  std::int64_t strip_id = 0;
  std::int64_t map_id = 0;  ///< of the accepted fixes; else of the newest record
  double map_sigma_m = 0;
  std::vector<KeyframeFix> keyframes;  ///< by id
  std::size_t registered = 0, fixed = 0, accepted = 0;
  host::ErrorSummary off_by_vehicle, off_by_first, off_by_all;  ///< m
  /// Camera centres on the map; empty where the fixes, or the vehicle's measurements, do not determine it, and where no
  /// fix comes after the first ones.
  std::vector<Vec3> track_by_vehicle, track_by_first, track_by_all;
};

struct FixSummary {
  std::vector<StripFixes> strips;  ///< those with a fix record
  std::size_t keyframes = 0, registered = 0, fixed = 0, accepted = 0;
  std::map<MapVerdict, std::size_t> verdicts;
  std::map<MapSense, std::size_t> senses;  ///< of the fixed ones

  [[nodiscard]] bool empty() const { return strips.empty(); }
};

/// Fixes of a strip by which `off_by_first_m` counts.
inline constexpr std::size_t first_fixes = 8;

/// Whether the keyframe was compared with the map at all.
[[nodiscard]] bool was_registered(const FixRecord& fix);

/// Of a flight before its strips are joined, in whose worlds the fixes were made.
[[nodiscard]] FixSummary fixes_of(const intake::Flight& flight);

}  // namespace ilp::fixes
