// Landforms that cover the whole plane: dunes, channels, terraces.
#pragma once

#include <cstdint>

#include "sim/world/landforms.hpp"
#include "sim/world/lattice_noise.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

/// Transverse dunes; the lee side is the steep one (R. A. Bagnold, 1941).
class Dunes {
 public:
  explicit Dunes(const WorldParams& world);

  /// Height in [-dune_height_m / 2, dune_height_m / 2], and the logarithm of the brightness: crests are brighter.
  /// `warp` and `vigour`, in [-1, 1], bend the crests and vary the height: noise much longer than a dune.
  [[nodiscard]] Relief relief(double x, double y, double warp, double vigour) const;
  /// Wavelength of the noise for both.
  [[nodiscard]] double warp_wavelength_m() const { return 5 * wavelength_m_; }

 private:
  double height_m_, wavelength_m_;
  double wind_x_, wind_y_;  // unit vector over the wavelength
  double crest_;            // place of the crest in a period, 0.5 to 0.9
};

/// Channels side by side with flat floors and smooth banks, each in a lane of its own; the meanders are some eleven
/// widths long (L. B. Leopold, M. G. Wolman, 1960).
class Channels {
 public:
  Channels(const WorldParams& world, std::uint32_t seed);

  /// How deep a place lies in a channel: 0 outside, 1 on the floor.
  [[nodiscard]] double depth(double x, double y) const;
  /// Calls visit(x, y) along the centre lines, about every `step_m`, for what lies in the rectangle.
  template <typename Visit>
  void visit_centre_lines(const Rectangle& area, double step_m, Visit visit) const;

 private:
  struct Centre {
    double across_m, slope;
  };
  [[nodiscard]] Centre centre(std::int32_t lane, double along_m) const;

  double width_m_, spacing_m_, swing_m_, bend_m_;
  double along_x_, along_y_;
  std::uint32_t seed_;
};

/// A height on layered ground: treads that keep a part of their slope, and scarps in the middle between two layers.
/// Steepness 0 changes nothing, 1 makes scarps a tenth as wide as the slope was.
[[nodiscard]] double terrace(double height_m, double step_m, double steepness);

template <typename Visit>
void Channels::visit_centre_lines(const Rectangle& area, double step_m, Visit visit) const {
  double a0 = 1e300, a1 = -1e300, c0 = 1e300, c1 = -1e300;
  for (const double x : {area.x0, area.x1}) {
    for (const double y : {area.y0, area.y1}) {
      const double along = along_x_ * x + along_y_ * y;
      const double across = along_x_ * y - along_y_ * x;
      a0 = along < a0 ? along : a0;
      a1 = along > a1 ? along : a1;
      c0 = across < c0 ? across : c0;
      c1 = across > c1 ? across : c1;
    }
  }
  const std::int32_t last_lane = floor_to_int(c1 / spacing_m_) + 1;
  const std::int32_t last_step = floor_to_int(a1 / step_m) + 1;
  for (std::int32_t lane = floor_to_int(c0 / spacing_m_) - 1; lane <= last_lane; ++lane) {
    for (std::int32_t k = floor_to_int(a0 / step_m); k <= last_step; ++k) {
      const double along = k * step_m;
      const double across = centre(lane, along).across_m;
      const double x = along_x_ * along - along_y_ * across;
      const double y = along_y_ * along + along_x_ * across;
      if (x >= area.x0 && x <= area.x1 && y >= area.y0 && y <= area.y1) visit(x, y);
    }
  }
}

}  // namespace ilp::world
