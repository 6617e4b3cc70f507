// The focal length over a plane from homographies and measurements, against cameras that the test places.
#include "fsw/vision/calibration/plane_focal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

enum class Measured { attitude, attitude_and_height, all };

struct PlaneFlight {
  Measured measured = Measured::all;
  double focal = 1;  ///< true, centred units
  double centre[2] = {0.01, -0.008};
  double swing_rad = 0.1;
  std::size_t keyframes = 30;
  double baseline_m = 16, height_m = 100;
  double height_noise = 0.01;  ///< share of the height
  double place_noise_m = 2;
  double attitude_noise_rad = 0.0087;
  double match_noise = 0.0004;  ///< centred units: 0.2 px of 560
  double relief_m = 0;          ///< deviation of the ground's mean height from pair to pair
  unsigned seed = 1;
};

std::vector<PlaneView> views_of(const PlaneFlight& flight) {
  std::mt19937 random(flight.seed);
  std::normal_distribution<double> normal(0, 1);
  Mat3 k;
  k << flight.focal, 0, flight.centre[0], 0, flight.focal, flight.centre[1], 0, 0, 1;
  Mat3 down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500;
  std::vector<PlaneView> views;
  Mat3 rotation_before;
  Vec3 place_before;
  for (std::size_t i = 0; i < flight.keyframes; ++i) {
    const auto t = static_cast<double>(i);
    const Vec3 tilt(flight.swing_rad * std::sin(1.9 * t), 0.5 * flight.swing_rad * std::cos(1.3 * t),
                    0.2 * std::sin(0.3 * t));
    const Mat3 rotation = rotation_from_vector(tilt) * down;
    const Vec3 place(flight.baseline_m * t, 4 * std::sin(0.2 * t), flight.height_m * (1 + 0.03 * std::sin(0.4 * t)));
    PlaneView view;
    if (i > 0) {
      const double height = place_before.z() - flight.relief_m * normal(random);
      const Mat3 plane = k * rotation *
                         (Mat3::Identity() + (place_before - place) * -1 * Vec3(0, 0, 1).transpose() / height) *
                         rotation_before.transpose() * k.inverse();
      PointPairs pairs;
      InlierMask inliers;
      for (int p = 0; p < 400; ++p) {
        const double u = 320 * (2 * (static_cast<double>(random()) / 4294967295.0) - 1);
        const double v = 240 * (2 * (static_cast<double>(random()) / 4294967295.0) - 1);
        const Vec3 q = plane * Vec3(u / 560, v / 560, 1);
        const double noise = 560 * flight.match_noise;
        const bool wrong = p % 20 == 0;
        static_cast<void>(pairs.push_back({u, v, 560 * q.x() / q.z() + noise * normal(random) + (wrong ? 30 : 0),
                                           560 * q.y() / q.z() + noise * normal(random), 1}));
        static_cast<void>(inliers.push_back(1));
      }
      EXPECT_TRUE(fit_plane_pair(pairs, inliers, CentredFrame(camera), view.pair));
      view.pair.motion = 0.16 * flight.focal;
    }
    const Vec3 error(normal(random), normal(random), normal(random));
    quaternion_from_rotation(rotation_from_vector(flight.attitude_noise_rad * error) * rotation, view.q_cam_from_level);
    view.tilt_sigma_rad = view.heading_sigma_rad = flight.attitude_noise_rad;
    view.height_m = place.z() * (1 + flight.height_noise * normal(random));
    view.height_sigma_m = flight.measured == Measured::attitude ? 0 : flight.height_noise * view.height_m;
    for (int axis = 0; axis < 3; ++axis) {
      view.place_m[axis] = 1000 + place[axis] + flight.place_noise_m * normal(random);
    }
    view.horizontal_sigma_m = flight.measured == Measured::all ? flight.place_noise_m : 0;
    views.push_back(view);
    rotation_before = rotation;
    place_before = place;
  }
  return views;
}

/// Errors of many flights: their root mean square in per cent, and in stated sigmas.
struct Spread {
  double percent = 0, sigmas = 0, stated_percent = 0;
  int found = 0;
};
Spread fly(PlaneFlight flight, int flights) {
  Spread out;
  for (int i = 0; i < flights; ++i) {
    flight.seed = 1 + static_cast<unsigned>(i);
    flight.focal = 0.8 + 0.02 * i;
    const std::vector<PlaneView> views = views_of(flight);
    const PlaneFocal found = find_plane_focal(views, 0.85 * flight.focal, {});
    if (!found.found) continue;
    ++out.found;
    const double error = found.focal - flight.focal;
    out.percent += 1e4 * error * error / (flight.focal * flight.focal);
    out.sigmas += error * error / (found.sigma * found.sigma);
    out.stated_percent += 100 * found.sigma / found.focal;
  }
  out.percent = std::sqrt(out.percent / out.found);
  out.sigmas = std::sqrt(out.sigmas / out.found);
  out.stated_percent /= out.found;
  static constexpr const char* measured[] = {"attitudes", "attitudes and heights", "all"};
  std::printf("%zu keyframes, %s measured: %d found, off by %.3f %%, %.2f sigma; stated %.3f %%\n", flight.keyframes,
              measured[static_cast<int>(flight.measured)], out.found, out.percent, out.sigmas, out.stated_percent);
  return out;
}

TEST(PlaneFocal, HeightsAndPlacesGiveItWithinTwiceTheirOwnErrors) {
  PlaneFlight flight;
  for (const std::size_t keyframes : {12U, 30U, 60U}) {
    flight.keyframes = keyframes;
    const Spread spread = fly(flight, 30);
    EXPECT_EQ(spread.found, 30);
    // f = motion * height / distance: mean height, both ends of the track, and the attitudes there.
    const auto n = static_cast<double>(keyframes);
    const double length_m = flight.baseline_m * (n - 1);
    const double bound =
        100 * std::sqrt(std::pow(flight.height_noise, 2) / n + 12 * std::pow(flight.place_noise_m / length_m, 2) / n);
    EXPECT_LT(spread.percent, 2 * bound + 0.05) << keyframes;
    EXPECT_LT(spread.sigmas, 1.5);
  }
}

TEST(PlaneFocal, GroundThatRisesAndFallsIsPartOfTheError) {
  PlaneFlight flight;
  flight.relief_m = 1;
  const Spread spread = fly(flight, 30);
  EXPECT_LT(spread.sigmas, 1.5);
}

TEST(PlaneFocal, AttitudesOfACameraThatSwingsAreEnough) {
  PlaneFlight flight;
  flight.attitude_noise_rad = 0.0035;
  for (const bool height : {false, true}) {
    flight.measured = height ? Measured::attitude_and_height : Measured::attitude;
    const Spread spread = fly(flight, 30);
    EXPECT_EQ(spread.found, 30);
    EXPECT_LT(spread.percent, 1.5);
    EXPECT_LT(spread.sigmas, 1.5);
  }
}

TEST(PlaneFocal, PoorAttitudesOverReliefAreNoMeasurement) {
  PlaneFlight flight;
  flight.measured = Measured::attitude;
  // As relief of 1 % of the height does.
  flight.match_noise = 0.0016;
  for (const double noise : {0.0087, 0.03, 0.1}) {
    flight.attitude_noise_rad = noise;
    const Spread spread = fly(flight, 30);
    EXPECT_EQ(spread.found > 0, noise < 0.05);
    if (spread.found > 0) {
      EXPECT_LT(spread.sigmas, 2);
    }
  }
}

TEST(PlaneFocal, WithoutASwingAttitudesSayThatTheyDoNotKnow) {
  PlaneFlight flight;
  flight.swing_rad = 0;
  flight.measured = Measured::attitude;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    flight.seed = seed;
    const PlaneFocal found = find_plane_focal(views_of(flight), 0.85 * flight.focal, {});
    EXPECT_TRUE(!found.found || found.sigma > 0.05 * found.focal) << found.focal << " +- " << found.sigma;
  }
}

TEST(PlaneFocal, WithoutAttitudesOrWithFewKeyframesThereIsNone) {
  PlaneFlight flight;
  std::vector<PlaneView> views = views_of(flight);
  EXPECT_FALSE(find_plane_focal({views.data(), 6}, 1, {}).found);
  for (PlaneView& view : views) view.heading_sigma_rad = 0;
  EXPECT_FALSE(find_plane_focal(views, 1, {}).found);
}

}  // namespace
}  // namespace ilp
