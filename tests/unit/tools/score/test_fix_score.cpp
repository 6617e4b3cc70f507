// Fixes whose errors are known against true cameras.
#include "sim/tools/score/fix_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace ilp::score {
namespace {

/// Cameras 100 m above level ground at 0, 20 m apart, which look straight down but for a tilt about y.
class Truth final : public report::Reference {
 public:
  Truth() {
    for (int id = 1; id <= 4; ++id) {
      const double tilt = 0.1 * id;
      report::ReferencePose& pose = poses_[std::to_string(id)];
      pose.cam_from_world << std::cos(tilt), 0, -std::sin(tilt), 0, -1, 0, -std::sin(tilt), 0, -std::cos(tilt);
      pose.centre = Vec3(20 * id, 5, 100);
    }
  }
  [[nodiscard]] const report::ReferencePose* pose(const std::string& name) const override {
    const auto found = poses_.find(name);
    return found == poses_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] host::Raster<float> depth(const std::string&) const override { return {}; }

 private:
  std::map<std::string, report::ReferencePose> poses_;
};

/// Off by (dx, dy) on the ground; one sigma is 0.5 m along x and 1 m along y.
FixRecord fix_off_by(int id, double dx, double dy) {
  FixRecord fix{.id = id, .map_id = 7, .state = FixState::accepted, .verdict = MapVerdict::fixed, .pixel_m = 2};
  fix.ground_m[0] = 20 * id - 100 * std::tan(0.1 * id) + dx;
  fix.ground_m[1] = 5 + dy;
  fix.ground_covariance[0] = 0.25;
  fix.ground_covariance[2] = 1;
  const double centre[3] = {20.0 * id + 3, 5, 100};
  std::copy_n(centre, 3, fix.centre_m);
  // Of the centre: 3 m along each axis.
  fix.covariance[9] = fix.covariance[14] = fix.covariance[20] = 9;
  fix.place_m[0] = 20 * id;
  fix.place_m[1] = 5 + 2;
  fix.place_sigma_m = 2;
  return fix;
}

intake::Flight flight_of(const std::vector<FixRecord>& fixes) {
  intake::Flight flight;
  for (const FixRecord& fix : fixes) {
    intake::Keyframe& keyframe = flight.keyframes[fix.id];
    keyframe.id = fix.id;
    keyframe.name = std::to_string(fix.id);
    keyframe.pose = PoseRecord{};
    keyframe.pose->state = PoseState::final;
    keyframe.fix = fix;
  }
  return flight;
}

TEST(FixScore, ErrorsAreThoseOfTheGroundWhereTheTrueAxisMeetsIt) {
  FixRecord none = fix_off_by(4, 0, 0);
  none.verdict = MapVerdict::no_agreement;
  none.state = FixState::none;
  const FixScore score =
      score_fixes(flight_of({fix_off_by(1, 1, 0), fix_off_by(2, 0, 1), fix_off_by(3, 0, 0), none}), Truth());
  const auto summary = fix_summary(score);
  EXPECT_DOUBLE_EQ(summary.at("fixed_share"), 0.75);
  EXPECT_DOUBLE_EQ(summary.at("fix_accepted_share"), 0.75);
  EXPECT_DOUBLE_EQ(summary.at("false_fixes"), 0);
  ASSERT_EQ(score.ground_px.size(), 3U);
  EXPECT_NEAR(score.ground_px[0], 0.5, 1e-9);
  EXPECT_NEAR(score.ground_px[1], 0.5, 1e-9);
  EXPECT_NEAR(score.ground_px[2], 0, 1e-9);
  EXPECT_NEAR(score.ground_nes[0], 2, 1e-9) << "two sigma along x";
  EXPECT_NEAR(score.ground_nes[1], 0.5, 1e-9) << "one sigma along y";
  EXPECT_NEAR(summary.at("fix_pose_nes"), 1.0 / 3, 1e-9) << "one sigma along one of three axes";
  EXPECT_NEAR(summary.at("fix_place_median_m"), 2, 1e-9);
  EXPECT_NEAR(summary.at("fix_place_nes"), 0.5, 1e-9);
}

TEST(FixScore, TheGroundIsThatOfThePixelWhichTheFlightTakesForItsPrincipalPoint) {
  CameraModel camera{640, 480, 500, 500, 319.5, 239.5};
  // The camera looks down, its x along that of the world: 10 px are 2 m from 100 m.
  intake::Flight flight = flight_of({fix_off_by(1, 0, 0)});
  const double tilt = 0.1, off = 0.02;
  flight.keyframes[1].fix->ground_m[0] = 20 - 100 * std::tan(tilt - std::atan(off));
  flight.camera = camera;
  flight.camera->cx += off * camera.fx;
  EXPECT_NEAR(score_fixes(flight, Truth(), camera).ground_m[0], 0, 1e-9);
  EXPECT_GT(score_fixes(flight, Truth()).ground_m[0], 1.9);
}

TEST(FixScore, AFixThatIsFarOffByPixelsAndBySigmasIsFalse) {
  FixRecord honest = fix_off_by(2, 9, 0);
  honest.ground_covariance[0] = 25;
  FixRecord unconfirmed = fix_off_by(3, 0, 40);
  unconfirmed.state = FixState::unconfirmed;
  const FixScore score = score_fixes(flight_of({fix_off_by(1, 9, 0), honest, unconfirmed}), Truth());
  EXPECT_EQ(score.false_fixes, 2U);
  EXPECT_EQ(score.false_accepted, 1U);
}

TEST(FixScore, WithoutAMapThereAreNoNumbers) {
  FixRecord without = fix_off_by(1, 0, 0);
  without.map_id = 0;
  EXPECT_TRUE(fix_summary(score_fixes(flight_of({without}), Truth())).empty());
}

}  // namespace
}  // namespace ilp::score
