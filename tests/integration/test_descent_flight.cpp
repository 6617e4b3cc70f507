// A descent straight down: the epipole stands in the middle of every image, and the ground around it has depth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/intake/product.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

/// Flown once for all tests: from 300 m down to 180 m over relief, at half the default resolution.
fs::path descended(const char* name, const char* mission) {
  static const test::TemporaryFolder folder;
  fs::path out = folder / name;
  if (fs::exists(out)) return out;
  const fs::path file = folder / (std::string(name) + ".ini");
  std::ofstream(file) << mission;
  std::vector<std::string> command{ILP_SIL,     "--scenario", "mars-canyon", "--mission", file.string(),
                                   "--threads", "2",          "--out",       out.string()};
  for (const char* set :
       {"flight.kind=descent", "flight.descent_m_s=3", "flight.frames=20", "flight.interval_s=2", "camera.width=320",
        "camera.height=240", "camera.fx=275", "camera.fy=275", "camera.cx=-1", "camera.cy=-1"}) {
    command.insert(command.end(), {"--set", set});
  }
  test::run_well(command);
  return out;
}

/// Every keyframe is matched with the next one, and all that matches is kept, however uncertain.
fs::path descended() {
  return descended("all", "[stereo]\nlargest_depth_sigma = 1\npartner_reach = 1\n");
}

intake::Flight received(const fs::path& flight = descended()) {
  intake::Outbox outbox = intake::read_outbox(flight / "outbox");
  return intake::build_flight(outbox);
}

/// Relative errors of a flight's depths, sorted.
std::vector<double> depth_errors(const fs::path& folder) {
  const intake::Flight flight = received(folder);
  const report::ReferenceFiles reference(folder / "flight" / "truth" / "poses.txt",
                                         folder / "flight" / "truth" / "depth");
  const auto accuracy = report::measure_accuracy(flight, flight.strips.begin()->second, reference);
  EXPECT_TRUE(accuracy);
  std::vector<double> errors;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!accuracy || keyframe.inverse_depth.empty()) continue;
    const host::Raster<float> truth = reference.depth(keyframe.name);
    for (std::size_t i = 0; i < truth.samples.size(); ++i) {
      const double inverse = keyframe.inverse_depth.samples[i];
      if (!(inverse > 0)) continue;
      errors.push_back(std::fabs(accuracy->reference_from_strip.scale / inverse / truth.samples[i] - 1));
    }
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

double share_of_mask(const intake::Keyframe& keyframe) {
  const auto& samples = keyframe.mask.samples;
  return static_cast<double>(std::count_if(samples.begin(), samples.end(), [](auto v) { return v != 0; })) /
         static_cast<double>(samples.size());
}

TEST(DescentFlightTest, AllButTheLastKeyframeHaveDepth) {
  const intake::Flight flight = received();
  EXPECT_EQ(flight.strips.size(), 1U);
  ASSERT_GE(flight.keyframes.size(), 4U);
  for (const auto& [id, keyframe] : flight.keyframes) {
    ASSERT_TRUE(keyframe.depth) << "keyframe " << id;
    const bool is_last = id == flight.keyframes.rbegin()->first;
    EXPECT_EQ(keyframe.depth->verdict, is_last ? DepthVerdict::no_partner : DepthVerdict::ok) << "keyframe " << id;
  }
}

TEST(DescentFlightTest, DepthAgreesWithTheTruthAndTheEpipoleHasNone) {
  const intake::Flight flight = received();
  const report::ReferenceFiles reference(descended() / "flight" / "truth" / "poses.txt",
                                         descended() / "flight" / "truth" / "depth");
  ASSERT_FALSE(flight.strips.empty());
  const auto accuracy = report::measure_accuracy(flight, flight.strips.begin()->second, reference);
  ASSERT_TRUE(accuracy);
  const intake::Keyframe& first = flight.keyframes.begin()->second;
  const host::Raster<float> truth = reference.depth(first.name);
  ASSERT_TRUE(first.inverse_depth.same_size(truth.width, truth.height));
  const double scale = accuracy->reference_from_strip.scale;
  std::vector<double> errors;
  std::size_t around_the_epipole = 0;
  for (std::int32_t y = 0; y < truth.height; ++y) {
    for (std::int32_t x = 0; x < truth.width; ++x) {
      const auto i = static_cast<std::size_t>(y * truth.width + x);
      const float inverse = first.inverse_depth.samples[i];
      if (!(inverse > 0)) continue;
      errors.push_back(100 *
                       std::fabs(scale / static_cast<double>(inverse) / static_cast<double>(truth.samples[i]) - 1));
      // The camera moves along its optical axis.
      around_the_epipole += std::hypot(x - 159.5, y - 119.5) < 10 ? 1U : 0U;
    }
  }
  EXPECT_GT(static_cast<double>(errors.size()), 0.7 * static_cast<double>(truth.samples.size()));
  EXPECT_EQ(around_the_epipole, 0U);
  std::sort(errors.begin(), errors.end());
  ASSERT_FALSE(errors.empty());
  EXPECT_LT(errors[errors.size() / 2], 1.0) << "% of the depth";
  EXPECT_LT(errors[errors.size() * 95 / 100], 5.0) << "% of the depth";
}

TEST(DescentFlightTest, TheProductSaysWhereTheDiscWithoutDepthIsAndAllOtherCommonGroundHasDepth) {
  const intake::Flight flight = received();
  const report::ReferenceFiles reference(descended() / "flight" / "truth" / "poses.txt",
                                         descended() / "flight" / "truth" / "depth");
  const intake::Keyframe& first = flight.keyframes.begin()->second;
  ASSERT_TRUE(first.depth);
  const DepthRecord& record = *first.depth;
  ASSERT_GT(record.blind_radius_px, 10);
  ASSERT_LT(record.blind_radius_px, 60);
  EXPECT_NEAR(record.epipole_x, 159.5, 15) << "the camera moves along its optical axis";
  EXPECT_NEAR(record.epipole_y, 119.5, 15);
  const auto partner = flight.keyframes.find(record.partner_id);
  ASSERT_NE(partner, flight.keyframes.end());
  const report::ReferencePose* a = reference.pose(first.name);
  const report::ReferencePose* b = reference.pose(partner->second.name);
  ASSERT_TRUE(a != nullptr && b != nullptr);
  const host::Raster<float> truth = reference.depth(first.name);
  double outside = 0, with_depth = 0, inside = 0, inside_with_depth = 0;
  for (std::int32_t y = 0; y < truth.height; ++y) {
    for (std::int32_t x = 0; x < truth.width; ++x) {
      const auto i = static_cast<std::size_t>(y * truth.width + x);
      const bool depth = first.inverse_depth.samples[i] > 0;
      const double distance = std::hypot(x - record.epipole_x, y - record.epipole_y);
      // Lens distortion and the obliqueness of rays make the disc no exact circle in the image.
      if (distance < 0.97 * record.blind_radius_px) {
        inside += 1;
        inside_with_depth += depth ? 1 : 0;
      }
      if (distance < 1.03 * record.blind_radius_px) continue;
      const Vec2 n = normalised_from_pixel(first.camera, Vec2(x, y));
      const double z = truth.samples[i];
      const Vec3 q =
          b->cam_from_world * (a->cam_from_world.transpose() * Vec3(z * n.x(), z * n.y(), z) + a->centre - b->centre);
      const Vec2 pixel = pixel_from_normalised(first.camera, Vec2(q.x() / q.z(), q.y() / q.z()));
      constexpr double border = 3;
      if (!(pixel.x() > border && pixel.y() > border && pixel.x() < truth.width - 1 - border &&
            pixel.y() < truth.height - 1 - border)) {
        continue;
      }
      outside += 1;
      with_depth += depth ? 1 : 0;
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_EQ(inside_with_depth, 0);
  EXPECT_GT(outside, 0.6 * truth.width * truth.height);
  EXPECT_GT(with_depth / outside, 0.98);

  // The same stands in the product itself.
  for (const intake::ReceivedProduct& received_product : intake::read_outbox(descended() / "outbox").products) {
    if (received_product.kind != ProductKind::depth || received_product.keyframe_id != first.id) continue;
    const intake::Product product = intake::decode_product(received_product.bytes.bytes());
    const auto disc = product.metadata.numbers("blind_disc_px", 3);
    ASSERT_TRUE(disc);
    EXPECT_NEAR((*disc)[0], record.epipole_x, 1e-3);
    EXPECT_NEAR((*disc)[1], record.epipole_y, 1e-3);
    EXPECT_NEAR((*disc)[2], record.blind_radius_px, 1e-3);
    EXPECT_NEAR(product.metadata.number("pose_sigma").value_or(0), record.pose_sigma, 1e-6);
    EXPECT_GT(record.pose_sigma, 1e-4);
    EXPECT_LT(record.pose_sigma, 0.02);
    return;
  }
  ADD_FAILURE() << "no depth product of the first keyframe";
}

TEST(DescentFlightTest, GroundOnceShownIsNotSentAgain) {
  const intake::Flight flight = received();
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (id == flight.keyframes.begin()->first) {
      EXPECT_GT(share_of_mask(keyframe), 0.7);
    } else {
      EXPECT_LT(share_of_mask(keyframe), 0.15) << "keyframe " << id;
    }
  }
}

TEST(DescentFlightTest, FartherPartnersGiveSmallerErrorsAndWhatIsSeenBadlyIsNotSent) {
  const std::vector<double> next = depth_errors(descended());
  const std::vector<double> chosen = depth_errors(descended("chosen", ""));
  ASSERT_GT(chosen.size(), next.size() / 2);
  const auto share = [](const std::vector<double>& errors, double part) {
    return errors[static_cast<std::size_t>(part * static_cast<double>(errors.size() - 1))];
  };
  EXPECT_LT(share(chosen, 0.5), 0.8 * share(next, 0.5));
  EXPECT_LT(share(chosen, 0.95), 0.02);
  const intake::Flight flight = received(descended("chosen", ""));
  ASSERT_TRUE(flight.keyframes.begin()->second.depth);
  EXPECT_GT(flight.keyframes.begin()->second.depth->partner_id, flight.keyframes.begin()->first + 1);
}

}  // namespace
}  // namespace ilp
