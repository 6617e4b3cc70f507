// Summarises the fixes of a flight: which keyframes are placed on the map, and how large the position errors would be
// without them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::fixes {

/// One-sigma ellipse of a fix's ground point, without the error of the map's own position.
struct ErrorEllipse {
  double major_m = 0, minor_m = 0;  ///< semi-axes
  double direction_rad = 0;         ///< of the long axis, from x towards y
};
[[nodiscard]] ErrorEllipse ellipse_of(const FixRecord& fix);

/// A keyframe with a fix record. Distances are horizontal, between the fix's ground point on the map and the position
/// of the same point by a similarity that places the strip on the map. None: the similarity or the point is not
/// determined.
struct KeyframeFix {
  FixRecord fix;
  std::optional<double> off_by_vehicle_m;  ///< similarity from the vehicle's measurements of the whole strip
  std::optional<double> off_by_first_m;    ///< similarity from the strip's first fixes (first_fixes)
  double off_by_first_sigma_m = 0;         ///< sigma of that position from the errors of the first fixes
  std::optional<double> off_by_all_m;      ///< similarity from all accepted fixes of the strip
};

struct StripFixes {
  std::int64_t strip_id = 0;
  std::int64_t map_id = 0;             ///< map of the first accepted fix, else of the newest fix record
  double map_sigma_m = 0;              ///< horizontal sigma per axis of the map's own position
  std::vector<KeyframeFix> keyframes;  ///< in the order of the ids
  std::size_t registered = 0, fixed = 0, accepted = 0;
  /// Distances of the accepted fixes, m; those of off_by_first only after the first fixes.
  host::ErrorSummary off_by_vehicle, off_by_first, off_by_all;
  /// Camera centres on the map by the three similarities. Empty if the similarity is not determined; track_by_first
  /// also if no fix comes after the first ones.
  std::vector<Vec3> track_by_vehicle, track_by_first, track_by_all;
};

struct FixSummary {
  std::vector<StripFixes> strips;  ///< those with a fix record
  std::size_t keyframes = 0, registered = 0, fixed = 0, accepted = 0;
  std::map<MapVerdict, std::size_t> verdicts;
  std::map<MapSense, std::size_t> senses;  ///< counts over the keyframes with verdict fixed

  [[nodiscard]] bool empty() const { return strips.empty(); }
};

/// Number of accepted fixes at the strip's beginning that determine the similarity of `off_by_first_m`.
inline constexpr std::size_t first_fixes = 8;

/// Whether the keyframe was compared with the map.
[[nodiscard]] bool was_registered(const FixRecord& fix);

/// The summary of a flight. Its strips must not be joined yet, because fixes were made in the strips' own worlds.
[[nodiscard]] FixSummary fixes_of(const intake::Flight& flight);

}  // namespace ilp::fixes
