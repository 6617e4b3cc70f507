// Where the sun stands over a place of a body, from the calendar alone: low-precision positions of the planets and the
// rotation of the bodies. The error is below 0.3 degrees from 1950 to 2050, which is less than shading can tell.
//
// Sources: E. M. Standish, J. G. Williams, "Orbital Ephemerides of the Sun, Moon, and Planets", approximate positions
// 1800 to 2050 AD (Keplerian elements and their rates); B. A. Archinal et al., "Report of the IAU Working Group on
// Cartographic Coordinates and Rotational Elements: 2015", Celest. Mech. Dyn. Astr. 130:22, 2018.
#pragma once

#include "cfg/choices.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// The place of the body over which the sun stands in the zenith: longitude east positive; latitude planetocentric.
struct SubsolarPoint {
  double longitude_rad = 0, latitude_rad = 0;
};

/// `days` of UTC since 2000-01-01 12:00. For Titan the sun's direction is that for Saturn, for the Moon that for the
/// Earth: both are within 0.15 degrees. Zeros for a body that is none.
[[nodiscard]] SubsolarPoint subsolar_point(Body body, double days);

struct SunPlace {
  double azimuth_rad = 0;    ///< clockwise from north, 0 to 2 pi
  double elevation_rad = 0;  ///< above the plane across the local vertical, without refraction
};
[[nodiscard]] SunPlace sun_over(const SubsolarPoint& sun, double longitude_rad, double latitude_rad);

/// Days of UTC since 2000-01-01 12:00 at a mission time, `epoch_s` being mission time 0 in seconds since 1958-01-01
/// (MissionParameters::mission_epoch_s).
[[nodiscard]] double days_since_2000(double epoch_s, TimeNs time_ns);

}  // namespace ilp
