// Strips of a narrow camera about a body that turns by 1 to 28 degrees from image to image, where a turn of the body
// and a shift hardly differ: what has a pose has an honest error, and what can be posed is.
#include <gtest/gtest.h>

#include "tests/unit/vision/multiview/narrow_body.hpp"
#include "tests/unit/vision/multiview/sequence_run.hpp"

namespace ilp {
namespace {

using test::Collected;
using test::NarrowScene;
using test::StripKeyframe;
using test::SyntheticStrip;

struct Flown {
  std::vector<Collected> strips;
  std::vector<SequenceVerdict> verdicts;  ///< of every keyframe

  [[nodiscard]] std::size_t posed() const {
    std::size_t count = 0;
    for (const Collected& strip : strips) count += strip.cameras.size();
    return count;
  }
};

void end_strip(Sequence& sequence, Collected& out, Flown& flown) {
  test::end(sequence);
  test::collect(sequence, out);
  // The flight gives no pose where the first motion is open.
  if (sequence.begun() && !test::sequence_state.first_pair.ambiguous) flown.strips.push_back(out);
  out = {};
}

/// A keyframe that fails ends the strip and begins the next one.
Flown fly(const SyntheticStrip& truth) {
  Flown flown;
  Collected out;
  Sequence sequence(test::sequence_state, test::sequence_workspace);
  EXPECT_TRUE(sequence.begin_strip(truth.camera, {}).ok());
  for (std::size_t k = 0; k < truth.keyframes.size(); ++k) {
    const StripKeyframe& frame = truth.keyframes[k];
    const auto id = static_cast<std::int64_t>(k);
    SequenceReport report;
    EXPECT_TRUE(sequence.add_keyframe(id, frame.corners, frame.matches, k, report).ok());
    flown.verdicts.push_back(report.verdict);
    test::collect(sequence, out);
    if (report.verdict == SequenceVerdict::ok || report.verdict == SequenceVerdict::waiting) continue;
    end_strip(sequence, out, flown);
    EXPECT_TRUE(sequence.begin_strip(truth.camera, {}).ok());
    EXPECT_TRUE(sequence.add_keyframe(id, frame.corners, frame.matches, k, report).ok());
  }
  end_strip(sequence, out, flown);
  return flown;
}

/// Largest error of a camera's place over its stated one, in the gauge of the estimated errors: the first camera, and
/// the camera whose distance from it is the unit of length.
double worst_in_sigmas(const SyntheticStrip& truth, const Collected& strip) {
  const auto centre_in_first = [](const RigidTransform& first, const RigidTransform& camera) -> Vec3 {
    return first * inverse(camera).translation;
  };
  const auto truth_of = [&](std::size_t i) {
    return truth.keyframes[static_cast<std::size_t>(strip.cameras[i].keyframe_id)].truth;
  };
  const RigidTransform first = cam_from_world(strip.cameras[0].pose);
  double unit = 0;
  for (std::size_t i = 1; i < strip.cameras.size() && unit == 0; ++i) {
    const double length = centre_in_first(first, cam_from_world(strip.cameras[i].pose)).norm();
    if (std::fabs(length - 1) < 1e-9) unit = centre_in_first(truth_of(0), truth_of(i)).norm();
  }
  EXPECT_GT(unit, 0);
  double worst = 0;
  for (std::size_t i = 1; i < strip.cameras.size(); ++i) {
    const Vec3 place = centre_in_first(first, cam_from_world(strip.cameras[i].pose));
    const double error = (place - centre_in_first(truth_of(0), truth_of(i)) / unit).norm();
    const double* c = strip.cameras[i].covariance;  // lower triangle: 9, 14 and 20 are the variances of the place
    worst = std::max(worst, error / std::sqrt(c[9] + c[14] + c[20]));
  }
  return worst;
}

/// The share of the keyframes that are posed, over the seeds. Prints it with the largest error in estimated sigmas.
double expect_honest(const char* name, NarrowScene scene, const std::vector<unsigned>& seeds) {
  std::size_t posed = 0;
  double worst = 0;
  for (const unsigned seed : seeds) {
    scene.seed = seed;
    const SyntheticStrip truth = test::NarrowFlight(scene).strip();
    const Flown flown = fly(truth);
    for (const Collected& strip : flown.strips) {
      const double error = worst_in_sigmas(truth, strip);
      EXPECT_LT(error, 5) << "seed " << seed;
      worst = std::max(worst, error);
    }
    posed += flown.posed();
  }
  const double share = static_cast<double>(posed) / (static_cast<double>(seeds.size()) * scene.keyframes);
  std::printf("%s: %.1f %% posed, largest error %.1f sigmas\n", name, 100 * share, worst);
  return share;
}

std::vector<unsigned> seeds_to(unsigned last) {
  std::vector<unsigned> seeds;
  for (unsigned seed = 1; seed <= last; ++seed) seeds.push_back(seed);
  return seeds;
}

TEST(NarrowField, TurnsOfFiveToTwentyEightDegreesArePosed) {
  EXPECT_GT(expect_honest("5 to 28 degrees", {}, seeds_to(12)), 0.97);
  EXPECT_GT(expect_honest("5 to 28 degrees, few matches after the largest", {.kept_after = 0.1}, seeds_to(12)), 0.95);
}

TEST(NarrowField, TurnsOfFiveToNineDegreesArePosed) {
  const NarrowScene scene{.least_turn = 0.08, .most_turn = 0.16};
  NarrowScene close = scene;
  close.radius_px = 600;
  NarrowScene small = scene;
  small.radius_px = 100;
  small.pointing_px = 60;
  EXPECT_GT(expect_honest("5 to 9 degrees", scene, seeds_to(12)), 0.97);
  EXPECT_GT(expect_honest("5 to 9 degrees, close", close, seeds_to(12)), 0.97);
  EXPECT_GT(expect_honest("5 to 9 degrees, small body", small, seeds_to(12)), 0.85);
}

TEST(NarrowField, TurnsOfOneToThreeDegreesArePosedWhereTheyAreTold) {
  const NarrowScene scene{.least_turn = 0.02, .most_turn = 0.06};
  NarrowScene noisy = scene;
  noisy.noise_px = 0.4;
  EXPECT_GT(expect_honest("1 to 3 degrees", scene, seeds_to(12)), 0.9);
  EXPECT_GT(expect_honest("1 to 3 degrees, noise of 0.4 px", noisy, seeds_to(12)), 0.6);
}

TEST(NarrowField, ABodyTooSmallToTellWhichWayItTurnsGetsNoWrongPose) {
  expect_honest("1 to 3 degrees, small body",
                {.least_turn = 0.02, .most_turn = 0.06, .radius_px = 100, .pointing_px = 60}, seeds_to(50));
}

TEST(NarrowField, AFlightAroundABodyIsOneStrip) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Flown flown = fly(test::NarrowFlight({.least_turn = 0.3, .most_turn = 0.49, .seed = seed}).strip());
    EXPECT_EQ(flown.strips.size(), 1U) << "seed " << seed;
    for (const SequenceVerdict verdict : flown.verdicts) EXPECT_NE(verdict, SequenceVerdict::implausible) << seed;
  }
}

TEST(NarrowField, TheEdgeOfABodyThatStaysInItsPlaceHoldsNoCamera) {
  // In these two flights more known points lie on the edge than on the body at one keyframe.
  const NarrowScene scene{.at_edge = 60, .kept_after = 0.1};
  EXPECT_GT(expect_honest("5 to 28 degrees, edge, two flights", scene, {8, 89}), 0.9);
  EXPECT_GT(expect_honest("5 to 28 degrees, edge", {.at_edge = 60, .kept_after = 0.3}, seeds_to(10)), 0.9);
}

}  // namespace
}  // namespace ilp
