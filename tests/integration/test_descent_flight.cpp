// A descent straight down: the epipole stands in the middle of every image, and the ground around it has depth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/ground/accuracy.hpp"
#include "sim/ground/flight_model.hpp"
#include "sim/ground/reference_files.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

/// Flown once for all tests: from 300 m down to 180 m over relief, at half the default resolution.
const fs::path& descended() {
  static const test::TemporaryFolder folder;
  static const fs::path out = folder / "out";
  if (!fs::exists(out)) {
    std::vector<std::string> command{ILP_SIL, "--scenario", "mars-canyon", "--out", out.string(), "--threads", "2"};
    for (const char* set :
         {"flight.kind=descent", "flight.descent_m_s=3", "flight.frames=20", "flight.interval_s=2", "camera.width=320",
          "camera.height=240", "camera.fx=275", "camera.fy=275", "camera.cx=-1", "camera.cy=-1"}) {
      command.insert(command.end(), {"--set", set});
    }
    const test::ProgramResult result = test::run_program(command);
    EXPECT_EQ(result.exit_status, 0) << result.output;
  }
  return out;
}

ground::Flight received() {
  ground::Outbox outbox = ground::read_outbox(descended() / "outbox");
  return ground::build_flight(outbox);
}

double share_of_mask(const ground::Keyframe& keyframe) {
  const auto& samples = keyframe.mask.samples;
  return static_cast<double>(std::count_if(samples.begin(), samples.end(), [](auto v) { return v != 0; })) /
         static_cast<double>(samples.size());
}

TEST(DescentFlightTest, AllButTheLastKeyframeHaveDepth) {
  const ground::Flight flight = received();
  EXPECT_EQ(flight.strips.size(), 1U);
  ASSERT_GE(flight.keyframes.size(), 4U);
  for (const auto& [id, keyframe] : flight.keyframes) {
    ASSERT_TRUE(keyframe.depth) << "keyframe " << id;
    const bool is_last = id == flight.keyframes.rbegin()->first;
    EXPECT_EQ(keyframe.depth->verdict, is_last ? DepthVerdict::no_partner : DepthVerdict::ok) << "keyframe " << id;
  }
}

TEST(DescentFlightTest, DepthAgreesWithTheTruthAndTheEpipoleHasNone) {
  const ground::Flight flight = received();
  const ground::ReferenceFiles reference(descended() / "flight" / "truth" / "poses.txt",
                                         descended() / "flight" / "truth" / "depth");
  ASSERT_FALSE(flight.strips.empty());
  const auto accuracy = ground::measure_accuracy(flight, flight.strips.begin()->second, reference);
  ASSERT_TRUE(accuracy);
  const ground::Keyframe& first = flight.keyframes.begin()->second;
  const ground::Raster<float> truth = reference.depth(first.name);
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

TEST(DescentFlightTest, GroundOnceShownIsNotSentAgain) {
  const ground::Flight flight = received();
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (id == flight.keyframes.begin()->first) {
      EXPECT_GT(share_of_mask(keyframe), 0.7);
    } else {
      EXPECT_LT(share_of_mask(keyframe), 0.15) << "keyframe " << id;
    }
  }
}

}  // namespace
}  // namespace ilp
