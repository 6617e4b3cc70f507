// Scratch of verify_place; a component owns one.
#pragma once

#include <array>

#include "fsw/vision/place/place_verification.hpp"

namespace ilp {

struct PlaceMatchWorkspace {
  static constexpr std::size_t n = limits::max_place_features;
  /// Features that look alike; coordinates are of the full images.
  struct Alike {
    float xa, ya, xb, yb;
    std::uint16_t a, b;
    std::uint8_t distance;
  };
  std::array<std::array<std::uint8_t, n>, n> distance;  ///< of each pair of features, 255 at most
  FixedVector<Alike, n> matches;
  std::array<std::uint16_t, n> best_of_b;
};

}  // namespace ilp
