// Longitudes have no ends: everything that averages, compares or boxes them goes through these functions.
#pragma once

#include <span>

namespace ilp::host {

/// The same meridian, within half a turn of `reference_deg`.
[[nodiscard]] double longitude_near(double longitude_deg, double reference_deg);

/// The shortest arc that holds all of them. Both ends are from -180 to 180 degrees; `west_deg` is larger than
/// `east_deg` where the arc crosses 180 (RFC 7946, 5.2).
struct LongitudeArc {
  double west_deg = 0, east_deg = 0;
  /// Degrees from west to east.
  [[nodiscard]] double width_deg() const;
  [[nodiscard]] double middle_deg() const;
};
/// Of one longitude or more; of none an arc of nothing at 0.
[[nodiscard]] LongitudeArc longitude_arc(std::span<const double> longitudes_deg);

}  // namespace ilp::host
