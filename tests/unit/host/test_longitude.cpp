#include <gtest/gtest.h>

#include <vector>

#include "sim/host/longitude.hpp"

namespace ilp::host {
namespace {

TEST(Longitude, IsBroughtNearAnotherOne) {
  EXPECT_DOUBLE_EQ(longitude_near(-179.5, 179), 180.5);
  EXPECT_DOUBLE_EQ(longitude_near(359.5, 0), -0.5);
  EXPECT_DOUBLE_EQ(longitude_near(10, 12), 10);
  EXPECT_DOUBLE_EQ(longitude_near(730, 0), 10);
}

void expect_arc(const std::vector<double>& longitudes, double west, double east, double middle) {
  const LongitudeArc arc = longitude_arc(longitudes);
  EXPECT_NEAR(arc.west_deg, west, 1e-9);
  EXPECT_NEAR(arc.east_deg, east, 1e-9);
  EXPECT_NEAR(longitude_near(arc.middle_deg(), middle), middle, 1e-9);
  EXPECT_GE(arc.middle_deg(), -180);
  EXPECT_LE(arc.middle_deg(), 180);
}

TEST(Longitude, AnArcHoldsThemAllTheShortWay) {
  expect_arc({8.5, 8.25, 8.75}, 8.25, 8.75, 8.5);
  expect_arc({179.5, -179.75, 179.75}, 179.5, -179.75, 179.875);
  expect_arc({359.5, 0.25, 0.5}, -0.5, 0.5, 0);
  expect_arc({181, 179}, 179, -179, 180);
  expect_arc({42}, 42, 42, 42);
  EXPECT_DOUBLE_EQ(longitude_arc(std::vector<double>{179, 181}).width_deg(), 2);
  EXPECT_EQ(longitude_arc({}).width_deg(), 0);
}

}  // namespace
}  // namespace ilp::host
