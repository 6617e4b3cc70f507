// Scratch of verify_place; a component owns one.
#pragma once

#include <array>

#include "fsw/vision/place/descriptor_distance.hpp"
#include "fsw/vision/place/place_verification.hpp"

namespace ilp {

struct PlaceMatchWorkspace {
  static constexpr std::size_t n = limits::max_place_features;

  /// A pair of similar features.
  struct Alike {
    std::uint16_t a, b;
    std::uint8_t distance;
    std::uint8_t turn;  ///< angle of b minus angle of a
  };
  static constexpr std::size_t alike_of_few = limits::place_features * limits::place_features / 4;
  static_assert(n % 4 == 0);
  std::array<EightWords, n / 8 * descriptor_words> words_of_b;  ///< descriptors of image b, eight interleaved
  FixedVector<Alike, n * n / 16> alike;   ///< pairs within the largest distance, by feature a, then b
  FixedVector<Alike, alike_of_few> near;  ///< of these, those that one map or a neighbouring one may bring together
  FixedVector<Alike, n> matches;          ///< mutually best under some condition
  std::array<std::uint16_t, n> best_a, best_b;

  struct Point {
    double x, y;
  };
  std::array<Point, n> sent;                  ///< features of image a, mapped to image b by the present map
  std::array<Point, n> matched_a, matched_b;  ///< positions of `matches`

  static constexpr int shift_cells = 2 * limits::max_image_side / 24;
  std::array<std::uint16_t, static_cast<std::size_t>(shift_cells) * shift_cells> shifts;  ///< votes for shifts
};

}  // namespace ilp
