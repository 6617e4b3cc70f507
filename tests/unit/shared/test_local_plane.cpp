// The plane about a place of a body, against what defines the transverse Mercator projection: it keeps angles, and it
// is true along the meridian of its origin.
#include "fsw/shared/local_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr Body bodies[] = {Body::mars, Body::titan, Body::venus, Body::moon, Body::earth};

struct Offset {
  double m[3];
};
Offset offset(Body body, const BodyPlace& origin, const BodyPlace& place) {
  Offset at{};
  plane_from_place(body, origin, place, at.m);
  return at;
}

TEST(LocalPlane, TheMeridianHasItsTrueLength) {
  for (const Body body : bodies) {
    const BodyPlace origin{137, -4.5, 0};
    double arc = 0;
    constexpr int steps = 20000;
    for (int i = 0; i < steps; ++i) {
      const double latitude = origin.latitude_deg + 30.0 * (i + 0.5) / steps;
      arc += degree_lengths(body, latitude, 0).north_m * 30 / steps;
    }
    const Offset at = offset(body, origin, {137, 25.5, 0});
    EXPECT_NEAR(at.m[1], arc, 0.01);
    EXPECT_NEAR(at.m[0], 0, 1e-6);
  }
}

TEST(LocalPlane, ShapesAreKept) {
  const BodyPlace origin{179.9, 52, -2000};
  for (const Body body : bodies) {
    for (const double east : {0.0, 0.4, -1.0, 3.0}) {
      for (const double north : {0.0, 1.0, -2.0}) {
        const BodyPlace place{origin.longitude_deg + east, origin.latitude_deg + north, 100};
        const DegreeLengths degree = degree_lengths(body, place.latitude_deg, 0);
        constexpr double step_m = 10;
        const Offset west = offset(body, origin, {place.longitude_deg - step_m / degree.east_m, place.latitude_deg, 0});
        const Offset to_east =
            offset(body, origin, {place.longitude_deg + step_m / degree.east_m, place.latitude_deg, 0});
        const Offset south =
            offset(body, origin, {place.longitude_deg, place.latitude_deg - step_m / degree.north_m, 0});
        const Offset to_north =
            offset(body, origin, {place.longitude_deg, place.latitude_deg + step_m / degree.north_m, 0});
        const double ex = (to_east.m[0] - west.m[0]) / (2 * step_m), ey = (to_east.m[1] - west.m[1]) / (2 * step_m);
        const double nx = (to_north.m[0] - south.m[0]) / (2 * step_m), ny = (to_north.m[1] - south.m[1]) / (2 * step_m);
        EXPECT_NEAR(ex, ny, 1e-6);
        EXPECT_NEAR(ey, -nx, 1e-6);
        // Scale grows with the square of the distance from the meridian.
        const Offset at = offset(body, origin, place);
        EXPECT_NEAR(std::sqrt(ex * ex + ey * ey), std::cosh(at.m[0] / body_radii(body).equatorial_m), 2e-5);
        EXPECT_NEAR(plane_north(body, origin, place), std::atan2(-nx, ny), 1e-4);
        EXPECT_EQ(at.m[2], 2100);
      }
    }
  }
}

TEST(LocalPlane, TheWayBackIsExact) {
  for (const Body body : bodies) {
    const BodyPlace origin{-179.99, -61, 12};
    for (double x = -90000; x <= 90000; x += 30000) {
      for (double y = -90000; y <= 90000; y += 45000) {
        const double there[3] = {x, y, 5};
        const BodyPlace place = place_from_plane(body, origin, there);
        EXPECT_EQ(place.elevation_m, 17);
        const Offset back = offset(body, origin, place);
        EXPECT_NEAR(back.m[0], x, 1e-3);
        EXPECT_NEAR(back.m[1], y, 1e-3);
      }
    }
  }
}

TEST(LocalPlane, TheSphereIsThatOfSnyder) {
  // J. P. Snyder, "Map Projections: A Working Manual", USGS 1395, 1987, numerical examples: a sphere of radius 1,
  // origin 0 N 75 W, the place 40 30 N 73 30 W.
  const Offset at = offset(Body::mars, {-75, 0, 0}, {-73.5, 40.5, 0});
  EXPECT_NEAR(at.m[0] / 3396190, 0.0199077, 1e-7);
  EXPECT_NEAR(at.m[1] / 3396190, 0.7070276, 1e-7);
}

TEST(LocalPlane, PolesAndPlacesAQuarterOfATurnAwayHaveNumbers) {
  const BodyPlace origin{90, 18, 0};
  for (const Body body : bodies) {
    // A vehicle without a position often states 0, 0.
    for (const BodyPlace& place : {BodyPlace{0, 0, 0}, BodyPlace{180, 0, 0}, BodyPlace{90, 90, 0}, {90, -90, 0}}) {
      const Offset there = offset(body, origin, place), back = offset(body, place, origin);
      for (const double metres : {there.m[0], there.m[1], back.m[0], back.m[1]})
        EXPECT_TRUE(std::isfinite(metres)) << place.longitude_deg << " " << place.latitude_deg;
    }
    const Offset pole = offset(body, {90, 89, 0}, {90, 90, 0});
    EXPECT_NEAR(pole.m[1], degree_lengths(body, 89.5, 0).north_m, 0.2);
  }
}

TEST(LocalPlane, WithoutABodyThereIsNone) {
  EXPECT_EQ(offset(Body::none, {}, {1, 1, 1}).m[0], 0);
  EXPECT_EQ(plane_north(Body::none, {}, {1, 1, 1}), 0);
}

}  // namespace
}  // namespace ilp
