// Joined models of a narrow camera about a body that turns, against its exact truth.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "sim/ground/model/view_depths.hpp"
#include "tests/unit/ground/model/narrow_flight.hpp"

namespace ilp::model {
namespace {

using test::Course;
using test::NarrowFlight;
using test::NoisyFlight;

struct Tally {
  std::size_t keyframes = 0, members = 0, wrong = 0;
  std::string names;  ///< of the wrong ones, which are off by more than 1 % of the extent and by more than five times
                      ///< what is stated
};

void add(NarrowFlight& flight, const std::string& name, Tally& tally) {
  tally.keyframes += flight.truth_.size();
  for (const JoinedModel& model : flight.join().models) {
    for (const NarrowFlight::Placed& one : flight.placed_in(model)) {
      ++tally.members;
      if (one.error < 0.01 || one.error < 5 * one.sigma) continue;
      ++tally.wrong;
      tally.names += name + ", keyframe " + std::to_string(one.keyframe_id) + ": " + std::to_string(100 * one.error) +
                     " % of the extent, stated " + std::to_string(100 * one.sigma) + " %\n";
    }
  }
}

/// Strips alone, single keyframes between them, and pairs of single keyframes, of which the second one is linked with
/// the first one only, or with the strip as well.
Tally tally_of_courses(double on_edge) {
  Tally tally;
  for (const Course& course :
       {Course{0, 0.09, 0.3, 1}, Course{0, 0.3, 0.49, 1}, Course{1, 0.09, 0.3, 1}, Course{1, 0.09, 0.3, 2},
        Course{1, 0.3, 0.49, 1}, Course{2, 0.09, 0.3, 1}, Course{2, 0.09, 0.3, 2}}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      NarrowFlight flight(seed);
      flight.fly_course(course, on_edge);
      const std::string name = std::to_string(course.singles) + " single, turns to " + std::to_string(course.most) +
                               ", " + std::to_string(course.linked_back) + " back, seed " + std::to_string(seed);
      add(flight, name, tally);
    }
  }
  return tally;
}

TEST(NarrowModel, KeyframesAboutABodyThatTurnsComeIntoIt) {
  const Tally tally = tally_of_courses(0);
  EXPECT_EQ(tally.wrong, 0U) << tally.names;
  EXPECT_GE(static_cast<double>(tally.members), 0.98 * static_cast<double>(tally.keyframes));
}

// These matches say that the camera has only turned where it was.
TEST(NarrowModel, MatchesOnTheEdgeOfTheBodyPutNoKeyframeAtTheirNeighboursPlace) {
  std::vector<double> shares = {0.4, 0.5};
  if (const char* const other = std::getenv("ILP_EDGE_SHARE")) shares = {std::atof(other)};
  for (const double on_edge : shares) {
    const Tally tally = tally_of_courses(on_edge);
    EXPECT_EQ(tally.wrong, 0U) << on_edge << ", of " << tally.members << ":\n" << tally.names;
    EXPECT_GE(static_cast<double>(tally.members), 0.97 * static_cast<double>(tally.keyframes)) << on_edge;
  }
}

// A single keyframe that is linked with the end of one strip and the beginning of the next one sees no point of both.
TEST(NarrowModel, ErrorsAreStatedWhereDepthsAloneTellTheScaleOfAStrip) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    NarrowFlight flight(seed);
    flight.fly_course({1, 0.3, 0.49, 1}, 0);
    for (const JoinedModel& model : flight.join().models) {
      for (std::size_t i = 1; i < model.members.size(); ++i) {
        const double(&sigma)[3] = flight.flight_.keyframes[model.members[i].keyframe_id].pose->sigma;
        EXPECT_GT(std::hypot(sigma[0], sigma[1], sigma[2]), 1e-4 * NarrowFlight::distance);
      }
    }
  }
}

// Where nothing contradicts the turn, it is one.
TEST(NarrowModel, AKeyframeThatOnlyTurnsComesIntoTheModel) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    NarrowFlight flight(seed);
    flight.fly_strip(1, {0, 0.1, 0.2, 0.3}, Similarity{});
    flight.see_single(2, 0.3);
    flight.link_body(4, 5, 60, 0);
    flight.link_body(3, 5, 60, 0);
    const JoinedFlight joined = flight.join();
    ASSERT_EQ(joined.models.size(), 1U);
    ASSERT_EQ(joined.models[0].members.size(), 5U) << seed;
    EXPECT_LT(flight.placed_in(joined.models[0]).back().error, 0.02) << seed;
  }
}

TEST(NarrowModel, AKeyframeOfAWideCameraThatOnlyTurnsComesIntoTheModel) {
  NoisyFlight flight;
  flight.fly_two_lanes();
  flight.see_without_pose(11, test::looking_down(5, 0, 1.2));
  for (const std::int64_t place : {2, 3, 4}) flight.link(place, 11);
  const JoinedFlight joined = flight.join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].members.size(), 6U);
  EXPECT_LT(flight.position_error(Similarity{}, {11}), 0.002);
}

/// The depths of the points whose height above the plane z = 0 `height` tells, from one camera above them.
template <typename Height>
std::optional<double> relief_seen(double focal_px, double half_width, Height height) {
  Scene scene;
  View view;
  view.camera = camera_of_field(640, 480, 2 * std::atan(320 / focal_px));
  scene.views.push_back(view);
  std::vector<Vec3> points;
  const RigidTransform pose = test::looking_down(0, 0, 0, 1);
  for (double x = -half_width; x <= half_width; x += half_width / 8) {
    for (double y = -half_width; y <= half_width; y += half_width / 8) {
      points.emplace_back(x, y, height(x, y));
      const Vec3 p = pose * points.back();
      Track track;
      track.seen.push_back(
          {0, view.camera.fx * p.x() / p.z() + view.camera.cx, view.camera.fy * p.y() / p.z() + view.camera.cy});
      scene.tracks.push_back(track);
    }
  }
  const ViewDepths depths(scene, {[&](std::size_t t) { return &points[t]; }, [&](std::uint32_t) { return &pose; }});
  return depths.relief(0);
}

TEST(NarrowModel, NoPlaneStandsForABodyThatFillsTheImage) {
  const auto slope = [](double x, double y) { return 0.3 * x - 0.2 * y; };
  for (const double focal_px : {400.0, 5760.0}) {
    const double radius = 200 / focal_px;
    EXPECT_TRUE(relief_seen(focal_px, radius, slope)) << focal_px;
    EXPECT_FALSE(relief_seen(focal_px, radius, [radius](double x, double y) {
      return std::sqrt(std::fmax(0, radius * radius - x * x - y * y));
    })) << focal_px;
  }
}

}  // namespace
}  // namespace ilp::model
