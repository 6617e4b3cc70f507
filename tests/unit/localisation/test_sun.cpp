// Where the sun stands over a place of a body, against almanacs, other algorithms and what landers have reported.
#include "fsw/localisation/sun.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr double deg = pi / 180;

/// Days since 2000-01-01 12:00 of a date of the Gregorian calendar (J. Meeus, "Astronomical Algorithms", chapter 7).
double days_of(int year, int month, int day, double hour) {
  if (month <= 2) {
    --year;
    month += 12;
  }
  const int century = year / 100;
  const double julian = std::floor(365.25 * (year + 4716)) + std::floor(30.6001 * (month + 1)) + day + 2 - century +
                        century / 4 - 1524.5 + hour / 24;
  return julian - 2451545.0;
}

double elevation_deg(Body body, double days, double longitude_deg, double latitude_deg) {
  return sun_over(subsolar_point(body, days), longitude_deg * deg, latitude_deg * deg).elevation_rad / deg;
}
double turned(double degrees) {
  return degrees - 360 * std::floor(degrees / 360 + 0.5);
}

/// M. Allison, M. McEwen, "A post-Pathfinder evaluation of areocentric solar coordinates", Planet. Space Sci. 48, 2000,
/// with the constants of NASA's Mars24; degrees. It shares no step with the orbital elements.
struct AllisonMcEwen {
  double season, longitude, latitude;
};
AllisonMcEwen allison_mcewen(double utc_days) {
  const double t = utc_days + 69.184 / 86400;
  const double m = (19.3871 + 0.52402073 * t) * deg;
  const double fictitious = 270.3871 + 0.524038496 * t;
  const double terms[7][3] = {{0.0071, 2.2353, 49.409},  {0.0057, 2.7543, 168.173}, {0.0039, 1.1177, 191.837},
                              {0.0037, 15.7866, 21.736}, {0.0021, 2.1354, 15.704},  {0.0020, 2.4694, 95.528},
                              {0.0018, 32.8493, 49.095}};
  double centre = (10.691 + 3e-7 * t) * std::sin(m) + 0.623 * std::sin(2 * m) + 0.050 * std::sin(3 * m) +
                  0.005 * std::sin(4 * m) + 0.0005 * std::sin(5 * m);
  for (const auto& [size, period, phase] : terms) centre += size * std::cos((0.985626 * t / period + phase) * deg);
  const double season = fictitious + centre;
  const double time_equation = 2.861 * std::sin(2 * season * deg) - 0.071 * std::sin(4 * season * deg) +
                               0.002 * std::sin(6 * season * deg) - centre;
  const double sols = (t - 4.5) / 1.0274912517 + 44796.0 - 0.0009626;
  const double west = 360 * (sols - std::floor(sols)) + time_equation + 180;
  return {season, turned(-west), std::asin(0.42565 * std::sin(season * deg)) / deg};
}

TEST(Sun, TheComparisonIsThatOfMars24) {
  // Worked example of NASA's page: 2000-01-06 00:00 UTC has Ls 277.18758, and 23:38:54 true solar time at longitude 0.
  const AllisonMcEwen at = allison_mcewen(days_of(2000, 1, 6, 0));
  EXPECT_NEAR(turned(at.season - 277.18758), 0, 0.001);
  // Mars turns by 0.02 degrees in the leap seconds since then.
  EXPECT_NEAR(turned(-at.longitude - (23 + 38 / 60.0 + 54 / 3600.0) * 15 - 180), 0, 0.03);
}

TEST(Sun, OverMarsIsThatOfAllisonAndMcEwen) {
  for (double days = -3000; days < 16000; days += 123.4) {
    const SubsolarPoint point = subsolar_point(Body::mars, days);
    const AllisonMcEwen other = allison_mcewen(days);
    EXPECT_NEAR(turned(point.longitude_rad / deg - other.longitude), 0, 0.3) << days;
    EXPECT_NEAR(point.latitude_rad / deg, other.latitude, 0.3) << days;
  }
}

TEST(Sun, SeasonsOfTheEarthAreThoseOfTheAlmanac) {
  // Equinoxes and solstices of 2026 by the U.S. Naval Observatory.
  EXPECT_NEAR(subsolar_point(Body::earth, days_of(2026, 3, 20, 14 + 46 / 60.0)).latitude_rad / deg, 0, 0.02);
  EXPECT_NEAR(subsolar_point(Body::earth, days_of(2026, 6, 21, 8 + 24 / 60.0)).latitude_rad / deg, 23.436, 0.02);
  EXPECT_NEAR(subsolar_point(Body::earth, days_of(2026, 9, 23, 0 + 5 / 60.0)).latitude_rad / deg, 0, 0.02);
  // The equation of time: 16.4 minutes on 3 November, -14.2 minutes on 11 February.
  EXPECT_NEAR(turned(subsolar_point(Body::earth, days_of(2026, 11, 3, 12)).longitude_rad / deg), -16.4 / 4, 0.1);
  EXPECT_NEAR(turned(subsolar_point(Body::earth, days_of(2026, 2, 11, 12)).longitude_rad / deg), 14.2 / 4, 0.1);
}

TEST(Sun, OverTheMoonIsThatOfTheLandings) {
  // Place and elevation of the sun at touchdown by the mission reports of the Apollo programme.
  EXPECT_NEAR(elevation_deg(Body::moon, days_of(1969, 7, 20, 20 + 17.7 / 60), 23.473, 0.674), 10.8, 0.5);
  EXPECT_NEAR(elevation_deg(Body::moon, days_of(1969, 11, 19, 6 + 54.6 / 60), -23.422, -3.012), 5.1, 0.5);
  EXPECT_NEAR(elevation_deg(Body::moon, days_of(1971, 7, 30, 22 + 16.5 / 60), 3.634, 26.132), 12.2, 0.5);
  EXPECT_NEAR(elevation_deg(Body::moon, days_of(1972, 12, 11, 19 + 55.0 / 60), 30.772, 20.191), 13.3, 0.5);
}

TEST(Sun, OverTitanIsThatOfTheSeasonsAndOfATransit) {
  // Equinoxes and the northern summer solstice of Saturn.
  EXPECT_NEAR(subsolar_point(Body::titan, days_of(2009, 8, 11, 0)).latitude_rad / deg, 0, 0.4);
  EXPECT_NEAR(subsolar_point(Body::titan, days_of(2025, 5, 6, 0)).latitude_rad / deg, 0, 0.4);
  EXPECT_NEAR(subsolar_point(Body::titan, days_of(2017, 5, 24, 0)).latitude_rad / deg, 26.7, 0.4);
  // Titan, whose meridian 0 faces Saturn, casts its shadow on it: seen by the Hubble telescope on 2009-02-24 at 14:24
  // UTC, which is 70 minutes later (STScI-2009-12). The transit takes some hours.
  EXPECT_NEAR(turned(subsolar_point(Body::titan, days_of(2009, 2, 24, 13.2)).longitude_rad / deg - 180), 0, 3);
}

TEST(Sun, OverVenusIsThatOfItsMeridianAndOfALanding) {
  // The meridians count so that 320 degrees faced the Earth at 0 h on 1964-06-20, a few hours from the inferior
  // conjunction (IAU 1970): the sun stood over the far side. Rotation was less well known then.
  EXPECT_NEAR(turned(subsolar_point(Body::venus, days_of(1964, 6, 20, 0)).longitude_rad / deg - 140), 0, 3);
  // Venera 13: a solar zenith angle of 36 degrees.
  EXPECT_NEAR(elevation_deg(Body::venus, days_of(1982, 3, 1, 3 + 57 / 60.0), 303.69, -7.55), 90 - 36, 2);
}

TEST(Sun, AzimuthCountsFromNorthByEast) {
  const SubsolarPoint zenith{};
  EXPECT_NEAR(sun_over(zenith, -0.1, 0).azimuth_rad, pi / 2, 1e-12) << "east of a place west of it";
  EXPECT_NEAR(sun_over(zenith, 0.1, 0).azimuth_rad, 3 * pi / 2, 1e-12);
  EXPECT_NEAR(sun_over(zenith, 0, -0.1).azimuth_rad, 0, 1e-12);
  EXPECT_NEAR(sun_over(zenith, 0, 0.1).azimuth_rad, pi, 1e-12);
  EXPECT_NEAR(sun_over(zenith, 0, 0.1).elevation_rad, pi / 2 - 0.1, 1e-12);
  EXPECT_NEAR(sun_over(zenith, pi, 0).elevation_rad, -pi / 2, 1e-12);
}

TEST(Sun, TheCalendarBeginsInTheYear1958) {
  // The default epoch of a mission is 2026-01-01.
  EXPECT_NEAR(days_since_2000(2145916800, 86400 * ns_per_s), days_of(2026, 1, 2, 0), 1e-9);
}

}  // namespace
}  // namespace ilp
