// Computes direct sunlight on posts: angle of incidence and cast shadows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::world {

/// Number of posts around a rectangle of posts.
struct PostMargin {
  std::int32_t left = 1, right = 1;   ///< towards smaller and larger columns
  std::int32_t below = 1, above = 1;  ///< towards smaller and larger rows
};

/// Direct sunlight with shadows. The line from a post to the sun is sampled where it crosses the lattice's lines. The
/// light of a post depends on the heights only, not on the rectangle that is computed.
class Sunlight {
 public:
  static constexpr std::int32_t longest_shadow = 2048;  ///< largest length of a shadow, lattice lines

  /// The azimuth is from x towards y, the elevation above 0 and up to pi/2. Heights differ by at most `height_range_m`.
  Sunlight(double azimuth_rad, double elevation_rad, double spacing_m, double height_range_m);

  /// Number of posts around the rectangle whose heights `direct` needs.
  [[nodiscard]] const PostMargin& margin() const { return margin_; }

  /// `heights` has columns * rows posts, row by row, including the margin. `light` gets the posts without the margin,
  /// row by row. Light is proportional to the cosine of incidence; 1 is that of level ground. It decreases to 0 while
  /// the shadow's edge rises from the post to one post spacing above it.
  void direct(std::span<const double> heights, std::int32_t columns, std::int32_t rows,
              std::vector<double>& light) const;

 private:
  /// Adjacent posts of a row, with the heights below which they are in shadow.
  struct Chunk {
    static constexpr std::int32_t length = 32;
    std::int32_t column = 0, row = 0, count = 0;
    double horizon[length] = {};
  };
  /// The highest post in squares of `side` posts.
  struct Blocks {
    static constexpr std::int32_t side = 16;
    std::int32_t columns = 0;
    std::vector<double> highest;
    double top = 0;
  };

  [[nodiscard]] static Blocks blocks_of(std::span<const double> heights, std::int32_t columns, std::int32_t rows);
  [[nodiscard]] double highest_ahead(const Blocks& blocks, const Chunk& chunk, std::int32_t first,
                                     std::int32_t last) const;
  void raise_horizon(const double* heights, std::int32_t columns, std::int32_t step, Chunk& chunk) const;
  void find_horizon(const double* heights, std::int32_t columns, const Blocks& blocks, Chunk& chunk) const;
  [[nodiscard]] double facing(double slope_x, double slope_y) const;

  Vec3 sun_;
  double spacing_m_;
  bool along_x_;            // the line to the sun is sampled at steps in x, else in y
  std::int32_t direction_;  // +1 or -1, along that axis
  double drift_;            // posts along the other axis per step
  double rise_m_;           // of the line to the sun per step
  std::int32_t steps_;
  PostMargin margin_;
};

}  // namespace ilp::world
