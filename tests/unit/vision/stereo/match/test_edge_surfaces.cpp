// A block in front of a background, both textured, whose disparities were found with the faults of windows at its edge.
#include "fsw/vision/stereo/match/edge_surfaces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace ilp {
namespace {

constexpr std::int32_t width = 160, height = 96;
constexpr float far_px = 12, near_px = 20;

/// The block stands in columns 70 to 109 of the left image. To its left, columns 62 to 69 are hidden from the right
/// image.
struct Scene {
  std::vector<std::uint8_t> left, right, valid = std::vector<std::uint8_t>(width * height, 1);
  std::vector<float> disparity_px = std::vector<float>(width * height), sigma_px = disparity_px;
  std::vector<DisparityKind> kind = std::vector<DisparityKind>(width * height, DisparityKind::measured);
  double noise_grey = 1;
  double right_brighter = 0;
  bool blank = false;   ///< the background is
  bool smooth = false;  ///< the background is waves, so that counterparts a few pixels away are still alike

  static std::size_t at(std::int32_t x, std::int32_t y) { return static_cast<std::size_t>(y * width + x); }
  static bool in_block(std::int32_t x) { return x >= 70 && x < 110; }
  static float truth(std::int32_t x) { return in_block(x) ? near_px : far_px; }

  void make(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    std::vector<double> far_grey(static_cast<std::size_t>(2 * width * height)), near_grey = far_grey;
    for (std::size_t i = 0; i < far_grey.size(); ++i) {
      const double wave = std::sin(0.21 * static_cast<double>(i % (2 * width)));
      far_grey[i] = blank ? 140 : 90 + 25 * (smooth ? wave : normal(random));
    }
    for (double& grey : near_grey) grey = 150 + 25 * normal(random);
    const auto levels = [&](double grey) {
      return static_cast<std::uint8_t>(std::lround(std::clamp(grey + noise_grey * normal(random), 0.0, 255.0)));
    };
    left.assign(width * height, 0);
    right = left;
    for (std::int32_t y = 0; y < height; ++y) {
      const auto grey = [&](const std::vector<double>& surface, std::int32_t x) {
        return surface[static_cast<std::size_t>(y * 2 * width + x)];
      };
      for (std::int32_t x = 0; x < width; ++x) {
        left[at(x, y)] = levels(grey(in_block(x) ? near_grey : far_grey, x));
        const std::int32_t near_x = x + static_cast<std::int32_t>(near_px);
        const std::int32_t far_x = x + static_cast<std::int32_t>(far_px);
        right[at(x, y)] = levels(right_brighter + (in_block(near_x) ? grey(near_grey, near_x) : grey(far_grey, far_x)));
        disparity_px[at(x, y)] = truth(x);
        sigma_px[at(x, y)] = x >= 62 && x < 70 ? 0.0F : 0.1F;
      }
    }
  }

  void set(std::int32_t x_begin, std::int32_t x_end, float d, float sigma) {
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = x_begin; x < x_end; ++x) {
        disparity_px[at(x, y)] = d;
        sigma_px[at(x, y)] = sigma;
      }
    }
  }

  void decide(double surface_step_px = StereoParams{}.surface_step_px) {
    NccRows rows;
    rows.left = {left.data(), width, height};
    rows.right = {right.data(), width, height};
    rows.left_valid = {valid.data(), width, height};
    rows.right_valid = {valid.data(), width, height};
    StereoParams params{.surface_step_px = surface_step_px};
    const auto workspace = std::make_unique<EdgeWorkspace>();
    for (std::int32_t y = 0; y < height + edge_reach; ++y) {
      decide_edges_row(
          rows, params, y,
          {{disparity_px.data(), width, height}, {sigma_px.data(), width, height}, {kind.data(), width, height}},
          *workspace);
    }
  }

  /// Share of the pixels of these columns for which `holds(d, sigma)`, rows at the border left out.
  template <typename Holds>
  [[nodiscard]] double share(std::int32_t x_begin, std::int32_t x_end, Holds holds) const {
    int count = 0, all = 0;
    for (std::int32_t y = 8; y < height - 8; ++y) {
      for (std::int32_t x = x_begin; x < x_end; ++x, ++all) {
        count += holds(disparity_px[at(x, y)], sigma_px[at(x, y)]) ? 1 : 0;
      }
    }
    return static_cast<double>(count) / all;
  }
  [[nodiscard]] double share_at(std::int32_t x_begin, std::int32_t x_end, float truth_px) const {
    return share(x_begin, x_end, [&](float d, float sigma) { return sigma > 0 && std::fabs(d - truth_px) < 0.3F; });
  }
};

TEST(EdgeSurfaces, BackgroundThatTookTheDisparityOfTheBlockGetsItsOwn) {
  Scene scene;
  scene.make(1);
  scene.set(110, 113, near_px, 0.1F);
  scene.decide();
  EXPECT_GT(scene.share_at(110, 113, far_px), 0.95);
  EXPECT_GT(scene.share_at(72, 110, near_px), 0.99);
  EXPECT_GT(scene.share_at(113, 150, far_px), 0.99);
}

TEST(EdgeSurfaces, ImagesOfUnequalBrightnessGiveTheSame) {
  Scene scene{.right_brighter = 25};
  scene.make(2);
  scene.set(110, 113, near_px, 0.1F);
  scene.decide();
  EXPECT_GT(scene.share_at(110, 113, far_px), 0.95);
  EXPECT_GT(scene.share_at(72, 110, near_px), 0.99);
}

TEST(EdgeSurfaces, PixelsBetweenTwoSurfacesTakeTheOneThatTheyBelongTo) {
  Scene scene;
  scene.make(3);
  scene.set(108, 112, 0, 0);
  scene.decide();
  EXPECT_GT(scene.share_at(108, 110, near_px), 0.9);
  EXPECT_GT(scene.share_at(110, 112, far_px), 0.9);
}

TEST(EdgeSurfaces, GroundThatTheBlockHidesFromTheRightImageLosesItsDisparity) {
  Scene scene;
  scene.make(4);
  // Its counterparts would be on the block.
  scene.set(66, 70, far_px, 0.1F);
  scene.decide();
  EXPECT_LT(scene.share(66, 70, [](float, float sigma) { return sigma > 0; }), 0.1);
  EXPECT_GT(scene.share_at(72, 108, near_px), 0.99);
}

TEST(EdgeSurfaces, BlankGroundBesideTheBlockStaysEmpty) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Scene scene{.blank = true};
    scene.make(seed);
    // Only the first column sees the block in its closest neighbours.
    scene.set(110, 114, 0, 0);
    scene.decide();
    EXPECT_EQ(scene.share(111, 114, [](float, float sigma) { return sigma > 0; }), 0) << seed;
  }
}

/// Of the pixels of these columns that took a disparity: the share whose error reaches half the way between the
/// surfaces.
double suspect_share(const Scene& scene, std::int32_t x_begin, std::int32_t x_end) {
  int suspect = 0, taken = 0;
  for (std::int32_t y = 8; y < height - 8; ++y) {
    for (std::int32_t x = x_begin; x < x_end; ++x) {
      const float sigma = scene.sigma_px[Scene::at(x, y)];
      if (sigma <= 0 || scene.kind[Scene::at(x, y)] != DisparityKind::resolved) continue;
      ++taken;
      suspect += sigma >= 0.5F * (near_px - far_px) ? 1 : 0;
      EXPECT_GE(sigma, 0.4F);
    }
  }
  EXPECT_GT(taken, 100);
  return static_cast<double>(suspect) / std::max(taken, 1);
}

TEST(EdgeSurfaces, ADoubtfulChoiceHasAnErrorThatReachesTheOtherSurface) {
  Scene clear;
  clear.make(1);
  clear.set(110, 112, 0, 0);
  clear.decide();
  EXPECT_LT(suspect_share(clear, 108, 112), 0.2);
  // The same pixels, but a window found the block there, and noise leaves little between the surfaces.
  Scene suspect{.noise_grey = 12};
  suspect.make(1);
  suspect.set(110, 112, near_px, 0.1F);
  suspect.decide();
  EXPECT_GT(suspect_share(suspect, 108, 112), 0.8);
}

TEST(EdgeSurfaces, ADisparityThatTheImagesContradictIsNotTaken) {
  Scene scene{.smooth = true};
  scene.make(6);
  // What is beside the block has the disparity of the block, and all further on is off by the step of two surfaces.
  scene.set(110, 114, near_px, 0.1F);
  scene.set(114, width, far_px + 2.5F, 0.1F);
  scene.decide();
  EXPECT_LT(scene.share(110, 114, [](float d, float sigma) { return sigma > 0 && std::fabs(d - far_px - 2.5F) < 1; }),
            0.05);
}

TEST(EdgeSurfaces, SlopesAndFlatGroundStayAsTheyAre) {
  Scene scene;
  scene.make(5);
  for (std::int32_t x = 0; x < width; ++x) scene.set(x, x + 1, 12 + 0.4F * static_cast<float>(x), 0.1F);
  const std::vector<float> disparity_px = scene.disparity_px, sigma_px = scene.sigma_px;
  scene.decide();
  EXPECT_EQ(scene.disparity_px, disparity_px);
  EXPECT_EQ(scene.sigma_px, sigma_px);
}

TEST(EdgeSurfaces, WithoutAStepNothingChanges) {
  Scene scene;
  scene.make(1);
  scene.set(110, 113, near_px, 0.1F);
  const std::vector<float> disparity_px = scene.disparity_px;
  scene.decide(0);
  EXPECT_EQ(scene.disparity_px, disparity_px);
}

}  // namespace
}  // namespace ilp
