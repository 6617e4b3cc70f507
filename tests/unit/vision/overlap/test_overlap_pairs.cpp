// Random pairs with known overlap: how exact the answers are, and that no confident one is wrong.
// ILP_OVERLAP_PAIRS is the number of pairs of the mixture, the other tests take a share of it; ILP_OVERLAP_TEXTURES and
// ILP_OVERLAP_STREAM choose the ground and the pairs. The bounds of the verdicts were chosen on textures 100, 9000
// and 20000 with pairs 13, 113 and 213: a judgement of them needs others.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/unit/vision/overlap/mixed_pairs.hpp"

namespace ilp {
namespace {

using test::any_attitude;
using test::between;
using test::between_ratio;
using test::mixed_pair;
using test::MixedPair;
using test::somewhere;
using test::texture;
using test::textures;

constexpr int pairs = ILP_OVERLAP_PAIRS;
constexpr std::int32_t width = 160, height = 120;

OverlapResult measure(const test::Image& a, const test::Image& b, const OverlapParams& params) {
  static const auto workspace = std::make_unique<OverlapWorkspace>();
  OverlapResult result;
  const Status status = measure_overlap(a.view(), b.view(), params, *workspace, result);
  EXPECT_TRUE(status.ok()) << status_name(status.code);
  return result;
}

class Errors {
 public:
  void add(const OverlapResult& result, double truth) {
    ++asked_;
    if (result.verdict == OverlapVerdict::ok) errors_.push_back(std::fabs(result.overlap - truth));
  }
  [[nodiscard]] double answered() const { return static_cast<double>(errors_.size()) / asked_; }
  [[nodiscard]] double percentile(double share) {
    if (errors_.empty()) return 1;
    std::sort(errors_.begin(), errors_.end());
    return errors_[static_cast<std::size_t>(share * static_cast<double>(errors_.size() - 1))];
  }
  void report(const char* name) {
    testing::Test::RecordProperty(std::string(name) + "_answered", std::to_string(answered()));
    for (const double share : {0.5, 0.95, 1.0}) {
      testing::Test::RecordProperty(std::string(name) + "_p" + std::to_string(static_cast<int>(100 * share)),
                                    std::to_string(percentile(share)));
    }
    std::printf(
        "%-28s answered %5.1f %%  error of the overlap: median %.2f %%, 95th percentile %.2f %%, worst %.2f %%\n", name,
        100 * answered(), 100 * percentile(0.5), 100 * percentile(0.95), 100 * percentile(1));
  }

 private:
  int asked_ = 0;
  std::vector<double> errors_;
};

struct Conditions {
  const char* name;
  double max_rotation_rad, max_scale;  // of the pairs
  double max_gain, noise;
};

Errors errors_under(const Conditions& c, const OverlapParams& params, int count, std::int32_t w, std::int32_t h,
                    double texels) {
  Errors errors;
  for (int i = 0; i < count; ++i) {
    Rng rng(static_cast<std::uint64_t>(i), 11);
    const test::GroundTexture& ground = texture(rng.below(textures));
    const Similarity2 b_from_a =
        test::with_overlap(between(rng, 0.55, 0.97), between_ratio(rng, 1 / c.max_scale, c.max_scale),
                           between(rng, -c.max_rotation_rad, c.max_rotation_rad), between(rng, 0, 2 * pi), w, h);
    const Similarity2 ground_from_a = somewhere(rng, texels);
    test::Exposure first, second;
    first.mean = second.mean = 85;
    first.contrast = second.contrast = 24;
    first.noise = second.noise = c.noise;
    second.gain = between_ratio(rng, 1 / c.max_gain, c.max_gain);
    const test::Image a = test::look_at(ground, {}, ground_from_a, w, h, first, rng);
    const test::Image b =
        test::look_at(ground, {}, test::compose(ground_from_a, test::inverse(b_from_a)), w, h, second, rng);
    errors.add(measure(a, b, params), test::counted_overlap(b_from_a, w, h));
  }
  errors.report(c.name);
  return errors;
}

class OverlapOfRandomPairs : public testing::TestWithParam<int> {};

TEST_P(OverlapOfRandomPairs, ShiftAloneIsExactToOnePercent) {
  OverlapParams params{.max_rotation_rad = 0, .max_scale = 1};
  for (const bool full_size : {false, true}) {
    Errors errors = full_size ? errors_under({"shift, 640x480", 0, 1, 1, 2}, params, pairs / 60, 640, 480, 0.5)
                              : errors_under({"shift, 160x120", 0, 1, 1, 2}, params, pairs / 6, width, height, 2);
    EXPECT_GE(errors.answered(), 0.97);
    EXPECT_LT(errors.percentile(0.95), 0.01);
  }
}

TEST_P(OverlapOfRandomPairs, AnyTurnAndScaleWithGainAndNoiseIsExactToTwoPercent) {
  const double turn = pi;
  Errors small =
      errors_under({"any turn and scale, 160x120", turn, 1.25, 2, 4}, any_attitude(), pairs / 6, width, height, 2);
  EXPECT_GE(small.answered(), 0.95);
  EXPECT_LT(small.percentile(0.95), 0.02);
  Errors full =
      errors_under({"any turn and scale, 640x480", turn, 1.25, 2, 8}, any_attitude(), pairs / 60, 640, 480, 0.5);
  EXPECT_GE(full.answered(), 0.9);
  EXPECT_LT(full.percentile(0.95), 0.02);
}

// A nadir camera over ground with hills, all lengths in flying heights; the ground's height is between 0 and `relief`.
struct HillyScene {
  const test::GroundTexture& hills;
  const test::GroundTexture& albedo;
  double relief;

  [[nodiscard]] double height_at(double x, double y) const {
    return relief * std::clamp(0.5 + 0.25 * hills.at(60 * x, 60 * y), 0.0, 1.0);
  }
};
struct Camera {
  double x, y, z, turn_rad;
  std::int32_t w, h;

  [[nodiscard]] double focal() const { return 0.9 * w; }
  void ray(double px, double py, double& dx, double& dy) const {
    const double u = (px - 0.5 * (w - 1)) / focal(), v = (py - 0.5 * (h - 1)) / focal();
    dx = std::cos(turn_rad) * u - std::sin(turn_rad) * v;
    dy = std::sin(turn_rad) * u + std::cos(turn_rad) * v;
  }
  [[nodiscard]] bool sees(double gx, double gy, double gz) const {
    const double dx = (gx - x) / (z - gz), dy = (gy - y) / (z - gz);
    const double u = std::cos(turn_rad) * dx + std::sin(turn_rad) * dy;
    const double v = -std::sin(turn_rad) * dx + std::cos(turn_rad) * dy;
    return std::fabs(u) * focal() <= 0.5 * w && std::fabs(v) * focal() <= 0.5 * h;
  }
};

// The first point of the ground along the ray that leaves the camera downwards.
void meet_ground(const HillyScene& scene, const Camera& camera, double dx, double dy, double& gx, double& gy,
                 double& gz) {
  double above = camera.z - scene.relief, below = camera.z;
  constexpr int steps = 24;
  for (int k = 0; k < steps; ++k) {
    const double depth = camera.z - scene.relief * (1 - (k + 1.0) / steps);
    if (camera.z - depth <= scene.height_at(camera.x + depth * dx, camera.y + depth * dy)) {
      below = depth;
      break;
    }
    above = depth;
  }
  for (int k = 0; k < 6; ++k) {
    const double depth = 0.5 * (above + below);
    const bool under = camera.z - depth <= scene.height_at(camera.x + depth * dx, camera.y + depth * dy);
    (under ? below : above) = depth;
  }
  gx = camera.x + below * dx;
  gy = camera.y + below * dy;
  gz = camera.z - below;
}

test::Image photograph(const HillyScene& scene, const Camera& camera, Rng& rng) {
  test::Image image(camera.w, camera.h);
  for (std::int32_t y = 0; y < camera.h; ++y) {
    for (std::int32_t x = 0; x < camera.w; ++x) {
      double value = 0;
      for (int k = 0; k < 2; ++k) {
        double dx = 0, dy = 0, gx = 0, gy = 0, gz = 0;
        camera.ray(x + 0.5 * k - 0.25, y + 0.5 * k - 0.25, dx, dy);
        meet_ground(scene, camera, dx, dy, gx, gy, gz);
        value += 0.5 * scene.albedo.at(350 * gx, 350 * gy);
      }
      image.view().at(x, y) =
          static_cast<std::uint8_t>(std::clamp(110 + 28 * value + 2 * test::gaussian(rng) + 0.5, 0.0, 255.0));
    }
  }
  return image;
}

TEST_P(OverlapOfRandomPairs, ReliefOfAFifthOfTheHeightIsExactToThreePercent) {
  Errors errors;
  constexpr std::int32_t w = 320, h = 240;
  for (int i = 0; i < pairs / 60; ++i) {
    Rng rng(static_cast<std::uint64_t>(i), 12);
    const HillyScene scene{texture(5 * rng.below(2)), texture(rng.below(textures)), between(rng, 0.05, 0.2)};
    const Camera a{between(rng, 0, 10), between(rng, 0, 10), 1, between(rng, 0, 2 * pi), w, h};
    const double direction = between(rng, 0, 2 * pi), distance = between(rng, 0.05, 0.4);
    const Camera b{a.x + distance * std::cos(direction),
                   a.y + distance * std::sin(direction),
                   between_ratio(rng, 0.95, 1.05),
                   a.turn_rad + between(rng, -0.3, 0.3),
                   w,
                   h};
    int seen = 0, all = 0;
    for (std::int32_t y = 1; y < h; y += 4) {
      for (std::int32_t x = 1; x < w; x += 4, ++all) {
        double dx = 0, dy = 0, gx = 0, gy = 0, gz = 0;
        a.ray(x, y, dx, dy);
        meet_ground(scene, a, dx, dy, gx, gy, gz);
        seen += b.sees(gx, gy, gz) ? 1 : 0;
      }
    }
    const double truth = static_cast<double>(seen) / all;
    if (truth < 0.55) continue;
    const OverlapResult result = measure(photograph(scene, a, rng), photograph(scene, b, rng), {});
    errors.add(result, truth);
    if (result.verdict != OverlapVerdict::ok) continue;
    EXPECT_NEAR(result.overlap, truth, 0.05) << i;
  }
  errors.report("relief to 20 %, 320x240");
  EXPECT_GE(errors.answered(), 0.8);
  EXPECT_LT(errors.percentile(0.95), 0.03);
}

// Exposure changed by a known factor, and light that falls off to the corners: what it does to either measure.
TEST_P(OverlapOfRandomPairs, ExposureMayChange) {
  struct Change {
    const char* name;
    double gain, vignette;
  };
  for (const Change& change : {Change{"gain 1", 1, 0}, Change{"gain 1/2", 0.5, 0}, Change{"gain 1/4", 0.25, 0},
                               Change{"gain 2", 2, 0}, Change{"gain 4, clipped", 4, 0}, Change{"vignette", 1, 0.6}}) {
    for (const OverlapMethod method : {OverlapMethod::ncc, OverlapMethod::sad}) {
      Errors errors;
      for (int i = 0; i < pairs / 40; ++i) {
        Rng rng(static_cast<std::uint64_t>(i), 15);
        const test::GroundTexture& ground = texture(rng.below(textures));
        const Similarity2 b_from_a =
            test::with_overlap(between(rng, 0.55, 0.97), between_ratio(rng, 1 / 1.2, 1.2), between(rng, -0.3, 0.3),
                               between(rng, 0, 2 * pi), width, height);
        const Similarity2 from_a = somewhere(rng, 1.5);
        test::Exposure first, second;
        first.mean = second.mean = 75;
        first.contrast = second.contrast = 24;
        first.noise = second.noise = 2;
        first.vignette = second.vignette = change.vignette;
        second.gain = change.gain;
        const test::Image a = test::look_at(ground, {}, from_a, width, height, first, rng);
        const Similarity2 from_b = test::compose(from_a, test::inverse(b_from_a));
        const test::Image b = test::look_at(ground, {}, from_b, width, height, second, rng);
        OverlapParams params{.method = method};
        const double truth = test::counted_overlap(b_from_a, width, height);
        const OverlapResult result = measure(a, b, params);
        errors.add(result, truth);
        if (result.verdict == OverlapVerdict::ok) {
          EXPECT_NEAR(result.overlap, truth, 0.05) << change.name << " " << i;
        }
      }
      errors.report((std::string(method == OverlapMethod::ncc ? "ncc, " : "sad, ") + change.name).c_str());
      EXPECT_GE(errors.answered(), change.gain >= 0.5 && change.gain < 4 ? 0.8 : 0.2) << change.name;
    }
  }
}

TEST_P(OverlapOfRandomPairs, NoConfidentAnswerIsOffByMoreThanFivePercent) {
  struct Count {
    int asked = 0, answered = 0;
  };
  for (const OverlapMethod method : {OverlapMethod::ncc, OverlapMethod::sad}) {
    std::map<std::string, Count> counts;
    const int asked = method == OverlapMethod::ncc ? pairs : pairs / 8;
    for (int i = 0; i < asked; ++i) {
      const bool full_turn = i % 2 == 0;
      const MixedPair pair = mixed_pair(i, full_turn);
      OverlapParams params = full_turn ? any_attitude() : OverlapParams{};
      params.method = method;
      const OverlapResult result = measure(pair.a, pair.b, params);
      Count& count = counts[pair.kind];
      ++count.asked;
      if (result.verdict != OverlapVerdict::ok) continue;
      ++count.answered;
      EXPECT_NEAR(result.overlap, pair.truth, 0.05)
          << "pair " << i << ", " << pair.kind << ", ncc " << result.ncc << " " << result.ncc_second << " "
          << result.region_ncc << " " << result.repetition;
    }
    for (const auto& [kind, count] : counts) {
      std::printf("%s %-24s %5d asked, %5d answered\n", method == OverlapMethod::ncc ? "ncc" : "sad", kind.c_str(),
                  count.asked, count.answered);
    }
    // Half of them have little more contrast than noise.
    EXPECT_GT(counts["related"].answered, 0.3 * counts["related"].asked);
  }
}

INSTANTIATE_TEST_SUITE_P(ILP_OVERLAP_SUITE, OverlapOfRandomPairs, testing::Values(pairs));

}  // namespace
}  // namespace ilp
