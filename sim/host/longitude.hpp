// Arithmetic of longitudes that is correct across the 180-degree meridian. All code that averages, compares or bounds
// longitudes uses it.
#pragma once

#include <span>

namespace ilp::host {

/// The longitude of the same meridian that lies within 180 degrees of `reference_deg`.
[[nodiscard]] double longitude_near(double longitude_deg, double reference_deg);

/// An arc of longitudes with ends from -180 to 180 degrees. `west_deg` is larger than `east_deg` if the arc crosses the
/// 180-degree meridian (RFC 7946, 5.2).
struct LongitudeArc {
  double west_deg = 0, east_deg = 0;
  /// Length from west to east.
  [[nodiscard]] double width_deg() const;
  [[nodiscard]] double middle_deg() const;
};
/// The shortest arc that contains all longitudes; an arc of length 0 at 0 degrees if there are none.
[[nodiscard]] LongitudeArc longitude_arc(std::span<const double> longitudes_deg);

}  // namespace ilp::host
