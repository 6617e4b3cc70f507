// The direction of the sun at a point of a body, from the calendar alone: low-precision positions of the planets, and
// the rotation of the bodies. The error is below 0.3 degrees from 1950 to 2050, which is too small to be visible in
// shading.
//
// Sources: E. M. Standish, J. G. Williams, "Orbital Ephemerides of the Sun, Moon, and Planets", approximate positions
// 1800 to 2050 AD (Keplerian elements and their rates); B. A. Archinal et al., "Report of the IAU Working Group on
// Cartographic Coordinates and Rotational Elements: 2015", Celest. Mech. Dyn. Astr. 130:22, 2018.
#pragma once

#include "cfg/choices.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// The point of the body with the sun in the zenith. The longitude is positive to the east, the latitude
/// planetocentric.
struct SubsolarPoint {
  double longitude_rad = 0, latitude_rad = 0;
};

/// `days` are days of UTC since 2000-01-01 12:00. The direction to the sun from Titan is taken to be that from Saturn,
/// and from the Moon that from the Earth; the errors are below 0.15 degrees. Zeros for Body::none.
[[nodiscard]] SubsolarPoint subsolar_point(Body body, double days);

struct SunPlace {
  double azimuth_rad = 0;    ///< clockwise from north, 0 to 2 pi
  double elevation_rad = 0;  ///< above the plane across the local vertical, without refraction
};
/// Direction of the sun at a point of the body.
[[nodiscard]] SunPlace sun_over(const SubsolarPoint& sun, double longitude_rad, double latitude_rad);

/// Days of UTC since 2000-01-01 12:00 at mission time `time_ns`. `epoch_s` is MissionParameters::mission_epoch_s, the
/// instant of mission time 0 in s since 1958-01-01.
[[nodiscard]] double days_since_2000(double epoch_s, TimeNs time_ns);

}  // namespace ilp
