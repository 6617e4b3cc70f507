// Depth from two views as the flight makes it: resampled, matched, carried to the reference's own pixels.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {

struct Rectified {
  Image left, right, left_valid, right_valid;
};

inline Rectified resample(const RectifiedPair& pair, const View& a, const View& b, std::int32_t band = 1 << 20) {
  Rectified r{Image(pair.width, pair.height), Image(pair.width, pair.height), Image(pair.width, pair.height),
              Image(pair.width, pair.height)};
  for (std::int32_t y = 0; y < pair.height; y += band) {
    const std::int32_t end = std::min(y + band, pair.height);
    EXPECT_TRUE(
        resample_rows(pair, Side::left, a.camera, a.image.view(), y, end, r.left.view(), r.left_valid.view()).ok());
    EXPECT_TRUE(
        resample_rows(pair, Side::right, b.camera, b.image.view(), y, end, r.right.view(), r.right_valid.view()).ok());
  }
  return r;
}

struct DepthMap {
  std::vector<float> inverse_depth, sigma;
};

struct Disparities {
  std::int32_t width = 0, height = 0;
  std::vector<float> disparity, sigma;
  std::vector<DisparityKind> kind;

  [[nodiscard]] DisparityView view() {
    return {{disparity.data(), width, height}, {sigma.data(), width, height}, {kind.data(), width, height}};
  }
};

inline Disparities match(const Rectified& r, const DisparityRange& range) {
  static const auto workspace = std::make_unique<StereoWorkspace>();
  const std::int32_t width = r.left.view().width, height = r.left.view().height;
  Disparities out{
      width, height, std::vector<float>(r.left.pixels.size()), std::vector<float>(r.left.pixels.size()), {}};
  StereoMatcher matcher;
  EXPECT_TRUE(matcher
                  .begin(r.left.view(), r.right.view(), r.left_valid.view(), r.right_valid.view(), range, {},
                         *workspace, {{out.disparity.data(), width, height}, {out.sigma.data(), width, height}})
                  .ok());
  EXPECT_TRUE(do_all([&] { return matcher.step(50); }).ok());
  out.kind.assign(matcher.result().kind.data, matcher.result().kind.data + out.disparity.size());
  return out;
}

/// Adds what one pair gives to the map.
inline void reconstruct(const View& a, const View& b, const RectifiedPair& pair, const DisparityRange& range,
                        DepthMap& map) {
  Disparities d = match(resample(pair, a, b), range);
  const std::int32_t words = supported_words(a.camera.width);
  std::vector<std::uint64_t> supported(static_cast<std::size_t>(words * a.camera.height));
  EXPECT_TRUE(depth_rows(pair, a.camera, d.view(), 0, a.camera.height,
                         {{map.inverse_depth.data(), a.camera.width, a.camera.height},
                          {map.sigma.data(), a.camera.width, a.camera.height},
                          {supported.data(), words, a.camera.height}})
                  .ok());
}

inline DepthMap empty_map(const View& a) {
  return {std::vector<float>(a.image.pixels.size()), std::vector<float>(a.image.pixels.size())};
}

inline DepthMap reconstruct(const View& a, const View& b, const RectifiedPair& pair, const DisparityRange& range) {
  DepthMap map = empty_map(a);
  reconstruct(a, b, pair, range, map);
  return map;
}

inline DepthMap reconstruct(const View& a, const View& b, const RectificationPlan& plan) {
  DepthMap map = empty_map(a);
  for (std::size_t i = 0; i < plan.count; ++i) reconstruct(a, b, plan.panels[i].pair, plan.panels[i].range, map);
  return map;
}

}  // namespace ilp::test
