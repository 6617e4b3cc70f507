// Anchor files, and where they put a strip.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "sim/ground/export/georeference.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/export/strip_of_poses.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::exports {
namespace {

class AnchorTest : public ::testing::Test {
 protected:
  [[nodiscard]] Anchors read(const std::string& text, const Body* flown = nullptr) const {
    const std::filesystem::path path = folder_.path() / "anchor.json";
    std::ofstream(path) << text;
    return read_anchors(path, flown);
  }
  [[nodiscard]] std::string refusal(const std::string& text, const Body* flown = nullptr) const {
    return test::error_of([&] { (void)read(text, flown); });
  }
  [[nodiscard]] std::string refusal_of_strip(const std::string& members, const std::string& body = "mars") const {
    return refusal("{\"body\": \"" + body + "\", \"strips\": [{" + members + "}]}");
  }

  test::TemporaryFolder folder_;
};

bool names(const std::string& message, const std::string& part) {
  return message.find(part) != std::string::npos;
}

TEST_F(AnchorTest, AllMembersAreRead) {
  const Anchors anchors = read(R"({"body": "titan", "strips": [
      {"strip": 2, "keyframe": 7, "longitude": 192.3, "latitude": -10.6, "height": 120.5, "azimuth": -30,
       "metres_per_unit": 4.5},
      {"strip": 1, "longitude": 0, "latitude": 90, "height": 0}]})");
  EXPECT_STREQ(anchors.body->name, "Titan");
  ASSERT_NE(anchors.of(2), nullptr);
  EXPECT_EQ(anchors.of(2)->keyframe, 7);
  EXPECT_EQ(anchors.of(2)->longitude_deg, 192.3);
  EXPECT_EQ(anchors.of(2)->latitude_deg, -10.6);
  EXPECT_EQ(anchors.of(2)->height_m, 120.5);
  EXPECT_EQ(anchors.of(2)->azimuth_deg, -30);
  EXPECT_EQ(anchors.of(2)->metres_per_unit, 4.5);
  EXPECT_EQ(anchors.of(1)->keyframe, std::nullopt);
  EXPECT_EQ(anchors.of(3), nullptr);
}

TEST_F(AnchorTest, WhatIsWrongIsSaidByName) {
  EXPECT_TRUE(names(refusal("{"), "anchor.json: not JSON"));
  EXPECT_TRUE(names(refusal("[]"), "must be a JSON object"));
  EXPECT_TRUE(names(refusal(R"({"body": "mars"})"), "strips is missing"));
  EXPECT_TRUE(names(refusal(R"({"strips": []})"), "body is missing"));
  EXPECT_TRUE(names(refusal(R"({"body": "pluto", "strips": []})"), "mars, titan, venus, moon, earth"));
  EXPECT_TRUE(names(refusal(R"({"body": "mars", "strips": []})"), "an entry per strip"));
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 1, "longitude": 1, "latitude": 2)"), "height is missing"));
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 1, "lon": 1)"), "\"lon\" is none of its members"));
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 0.5, "longitude": 1, "latitude": 2, "height": 3)"),
                    "strip must be a whole number"));
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 1, "longitude": "12 E", "latitude": 2, "height": 3)"),
                    "longitude must be a number"));
  const std::string one = R"({"strip": 1, "longitude": 1, "latitude": 2, "height": 3})";
  EXPECT_TRUE(names(refusal(R"({"body": "mars", "strips": [)" + one + "," + one + "]}"), "entry 2 of strips"));
}

TEST_F(AnchorTest, APlaceThatIsNoneOnTheBodyIsRefused) {
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 1, "longitude": 361, "latitude": 2, "height": 3)"), "not 361"));
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 1, "longitude": 1, "latitude": -91, "height": 3)"), "not -91"));
  const std::string jezero = R"("strip": 1, "longitude": 77.6, "latitude": 18.4, "height": -2500)";
  EXPECT_EQ(refusal_of_strip(jezero), "");
  EXPECT_TRUE(names(refusal_of_strip(jezero, "earth"), "metres on Earth"));
  EXPECT_TRUE(names(refusal_of_strip(R"("strip": 1, "longitude": 1, "latitude": 2, "height": 1e9)"), "height"));
}

TEST_F(AnchorTest, AnotherBodyThanTheFlightSaysIsRefused) {
  const std::string text = R"({"body": "mars", "strips": [{"strip": 1, "longitude": 1, "latitude": 2, "height": 3}]})";
  EXPECT_EQ(refusal(text, flown_body("simulated world, scenario mars-canyon, seed 3")), "");
  EXPECT_EQ(refusal(text, flown_body("a folder of images")), "");
  EXPECT_TRUE(names(refusal(text, flown_body("simulated world, scenario titan-shore, seed 1")),
                    "on Mars, but the flight was over Titan"));
}

Anchors anchored_at(const char* body, double longitude, double latitude, double height, double azimuth,
                    std::optional<double> metres_per_unit, std::optional<std::int64_t> keyframe) {
  return {find_body(body), {{1, keyframe, longitude, latitude, height, azimuth, metres_per_unit}}};
}

TEST(GeoreferenceTest, WithoutAnAnchorTheStripKeepsItsAxesAndUnit) {
  const intake::Flight metres = test::strip_of_poses(true), units = test::strip_of_poses(false);
  const Georeference in_metres = georeference_of(metres, metres.strips.at(1), nullptr);
  const Georeference in_units = georeference_of(units, units.strips.at(1), nullptr);
  EXPECT_EQ(in_metres.unit, "metre");
  EXPECT_EQ(in_units.unit, "strip unit");
  EXPECT_TRUE(names(in_metres.crs, "ENGCRS"));
  EXPECT_TRUE(names(in_units.crs, "LENGTHUNIT[\"strip unit\""));
  EXPECT_FALSE(in_metres.on_a_body());
  EXPECT_EQ(in_units.map_from_world(Vec3(3, 4, 5)), Vec3(3, 4, 5));
}

TEST(GeoreferenceTest, TheAnchoredCameraIsAtItsPlaceAndTheAxesAreTurned) {
  const intake::Flight flight = test::strip_of_poses(false);
  const Anchors anchors = anchored_at("mars", 137.4, -4.6, -4000, 90, 2.0, 2);
  const Georeference place = georeference_of(flight, flight.strips.at(1), &anchors);
  EXPECT_LT((place.map_from_world(Vec3(8, 2, 10)) - Vec3(0, 0, -4000)).norm(), 1e-12);
  // +y looks east, so +x looks south.
  EXPECT_LT((place.map_from_world(Vec3(8, 3, 10)) - Vec3(2, 0, -4000)).norm(), 1e-9);
  EXPECT_LT((place.map_from_world(Vec3(9, 2, 10)) - Vec3(0, -2, -4000)).norm(), 1e-9);
  EXPECT_LT((place.map_from_world(Vec3(8, 2, 4)) - Vec3(0, 0, -4012)).norm(), 1e-9);
  EXPECT_TRUE(names(place.sentence, "Mars"));
  EXPECT_TRUE(names(place.sentence, "137.40000 E, 4.60000 S"));
}

TEST(GeoreferenceTest, GeotransformAndPointsAgreeAtEveryAzimuth) {
  const intake::Flight flight = test::strip_of_poses(true);
  const map::MapGeometry map{-40, 25, 0.125, 700, 600};
  for (const double azimuth : {0.0, 33.0, -120.0, 250.0}) {
    const Anchors anchors = anchored_at("moon", 12, 40, 100, azimuth, std::nullopt, std::nullopt);
    const Georeference place = georeference_of(flight, flight.strips.at(1), &anchors);
    const std::array<double, 6> t = geotransform(place, map);
    for (const auto& [column, row] : {std::pair(0, 0), std::pair(699, 0), std::pair(321, 512)}) {
      const Vec3 expected = place.map_from_world(Vec3(-40 + column * 0.125, 25 - row * 0.125, 0));
      EXPECT_NEAR(t[0] + t[1] * (column + 0.5) + t[2] * (row + 0.5), expected.x(), 1e-9);
      EXPECT_NEAR(t[3] + t[4] * (column + 0.5) + t[5] * (row + 0.5), expected.y(), 1e-9);
    }
  }
}

TEST(GeoreferenceTest, AKilometreNorthIsAsManyDegreesAsTheBodySays) {
  const intake::Flight flight = test::strip_of_poses(true);
  for (const auto& [key, radius] :
       {std::pair("mars", 3396190.0), {"titan", 2575000.0}, {"venus", 6051800.0}, {"moon", 1737400.0}}) {
    const Anchors anchors = anchored_at(key, 179.9999, 10, 0, 0, std::nullopt, std::nullopt);
    const Georeference place = georeference_of(flight, flight.strips.at(1), &anchors);
    const GeographicFromMap geographic(place);
    const std::array<double, 2> north = geographic(0, 1000), east = geographic(1000, 0);
    const double degree = radius * std::numbers::pi / 180;
    EXPECT_NEAR(north[1], 10 + 1000 / degree, 1e-7) << key;
    EXPECT_NEAR(north[0], 179.9999, 1e-9) << key;
    // On beyond 180 degrees, not back to -180.
    EXPECT_NEAR(east[0], 179.9999 + 1000 / (degree * std::cos(10 * std::numbers::pi / 180)), 1e-6) << key;
  }
}

TEST(GeoreferenceTest, AnEntryThatContradictsTheStripIsRefused) {
  const intake::Flight units = test::strip_of_poses(false), metres = test::strip_of_poses(true);
  const Anchors without = anchored_at("mars", 0, 0, 0, 0, std::nullopt, 1);
  const Anchors with = anchored_at("mars", 0, 0, 0, 0, 2.0, 1);
  EXPECT_THROW((void)georeference_of(units, units.strips.at(1), &without), std::runtime_error);
  EXPECT_THROW((void)georeference_of(metres, metres.strips.at(1), &with), std::runtime_error);
}

TEST(GeoreferenceTest, AKeyframeThatHasNotComeLeavesTheStripInItsAxesAndSaysSo) {
  const intake::Flight flight = test::strip_of_poses(true);
  const Anchors anchors = anchored_at("mars", 0, 0, 0, 0, std::nullopt, 9);
  const Georeference place = georeference_of(flight, flight.strips.at(1), &anchors);
  EXPECT_FALSE(place.on_a_body());
  EXPECT_TRUE(names(place.sentence, "keyframe 9, which its anchor names, has no pose"));
}

}  // namespace
}  // namespace ilp::exports
