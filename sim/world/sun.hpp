// Sunlight on posts: how squarely it falls, and what stands in its way.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::world {

/// Posts beyond a rectangle of posts.
struct PostMargin {
  std::int32_t left = 1, right = 1;   ///< towards smaller and larger columns
  std::int32_t below = 1, above = 1;  ///< towards smaller and larger rows
};

/// Direct sunlight, shadows included, however far off what casts them. The way from a post towards the sun is sampled
/// where it crosses the lattice's lines. A post's light depends on the heights only, not on which posts are lit at
/// once.
class Sunlight {
 public:
  static constexpr std::int32_t longest_shadow = 2048;  ///< lattice lines; shadows end there

  /// Angles in radians; azimuth from x towards y, elevation above 0 to pi/2. No post is higher than another by more
  /// than `height_range_m`.
  Sunlight(double azimuth_rad, double elevation_rad, double spacing_m, double height_range_m);

  /// How far around the posts to be lit `direct` needs heights.
  [[nodiscard]] const PostMargin& margin() const { return margin_; }

  /// `heights` holds columns * rows posts, row by row, the margin included; `light` gets those inside the margin. 1 is
  /// the light on level ground; it goes with the cosine of incidence, and from 1 down to 0 as the shadow's edge rises
  /// above the post by up to one post spacing.
  void direct(std::span<const double> heights, std::int32_t columns, std::int32_t rows,
              std::vector<double>& light) const;

 private:
  /// Posts side by side in a row, and the height below which each is in the shadow of another.
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
  bool along_x_;            // the lattice's lines are crossed along x, else along y
  std::int32_t direction_;  // +1 or -1, along that axis
  double drift_;            // posts along the other axis per line
  double rise_m_;           // of the way to the sun per line
  std::int32_t steps_;
  PostMargin margin_;
};

}  // namespace ilp::world
