// What the tests of places share: the features of an image, and views of an endless texture.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/place/place_feature_workspace.hpp"
#include "fsw/vision/place/place_match_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {

inline PlaceFeatures features_of(const Image& image, std::size_t wanted = limits::place_features) {
  static const auto harris = std::make_unique<HarrisWorkspace>();
  static const auto workspace = std::make_unique<PlaceFeatureWorkspace>();
  PlaceFeatures features;
  EXPECT_TRUE(find_place_features(image.view(), wanted, *harris, *workspace, features).ok());
  return features;
}

inline std::span<const PlaceFeature> all(const PlaceFeatures& features) {
  return {features.data(), features.size()};
}

inline PlaceMatch verify(const PlaceFeatures& older, const PlaceFeatures& newer) {
  static const auto workspace = std::make_unique<PlaceMatchWorkspace>();
  PlaceMatch match;
  EXPECT_TRUE(verify_place(all(older), all(newer), least_place_evidence, *workspace, match).ok());
  return match;
}

}  // namespace ilp::test
