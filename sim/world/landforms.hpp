// Landforms of the infinite plane: scattered craters, rocks, boulder fields and outcrops, and dunes, channels and
// terraces. Each size class of scattered landforms has a lattice with at most one landform per square, determined by a
// hash of the square.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/world/lattice_noise.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

struct Rectangle {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< m
};

/// One size class: landforms with radii from half of `radius_m` to `radius_m`. The number with radii above r is
/// proportional to r^-exponent.
struct SizeClass {
  double radius_m = 0;
  double cell_m = 0;       ///< side of the lattice's squares
  double probability = 0;  ///< of a landform in a square
  std::uint32_t seed = 0;
  double exponent = 2;
  double share = 1;  ///< `probability` divided by the density of the most crowded class
};

/// Makes the classes from `largest_m` down to `smallest_m`, each half as large as the one before. The squares of a
/// class are `cell_radii` times its radius wide. The numbers of all classes together follow the exponent; the most
/// crowded class has the probability `density`.
[[nodiscard]] std::vector<SizeClass> size_classes(double largest_m, double smallest_m, double exponent,
                                                  double cell_radii, double density, Rng& rng);

struct Crater {
  double x = 0, y = 0;  ///< centre, m
  double radius_m = 0;
  double freshness = 0;  ///< 0: worn, 1: new

  static constexpr double reach = 2.5;  ///< radii; the ejecta blanket ends here
};

struct Rock {
  double x = 0, y = 0;                          ///< centre, m
  double axis_x_per_m = 0, axis_y_per_m = 0;    ///< unit vector of the first semi-axis divided by its length
  double cross_x_per_m = 0, cross_y_per_m = 0;  ///< the same for the second semi-axis
  double reach_m = 0;                           ///< largest distance from the centre
  double height_m = 0;
  double albedo = 1;
  double draw = 0;  ///< random, in [0, probability of the class); ground of lower density keeps rocks with small values
};

/// Ground with more rocks than elsewhere.
struct BoulderField {
  double x = 0, y = 0;  ///< centre, m
  double radius_m = 0;

  [[nodiscard]] bool contains(double at_x, double at_y) const {
    return (at_x - x) * (at_x - x) + (at_y - y) * (at_y - y) < radius_m * radius_m;
  }
};

/// Exposed bedrock: a knob with ledges, broken by joints, of another brightness than the ground.
struct Outcrop {
  double x = 0, y = 0;                        ///< centre, m
  double axis_x_per_m = 0, axis_y_per_m = 0;  ///< as for Rock
  double cross_x_per_m = 0, cross_y_per_m = 0;
  double radius_m = 0;  ///< half the longest diameter
  double height_m = 0;
  double albedo = 1;
  std::uint32_t seed = 0;

  static constexpr double highest = 0.35;  ///< largest height including blocks, divided by the radius
};

/// Append the landforms of the class that may touch the rectangle, in an order that does not depend on the rectangle.
void find_craters(const SizeClass& size, const Rectangle& area, std::vector<Crater>& out);
void find_rocks(const SizeClass& size, const Rectangle& area, std::vector<Rock>& out);
void find_boulder_fields(const SizeClass& size, const Rectangle& area, std::vector<BoulderField>& out);
void find_outcrops(const SizeClass& size, const Rectangle& area, std::vector<Outcrop>& out);

/// Change of the ground by a landform at a point.
struct Relief {
  double height_m = 0;
  double albedo = 1;  ///< factor
};

/// Bowl, raised rim, and ejecta that thin outwards. A new crater is 0.2 diameters deep, and its rim is 0.04 diameters
/// high (R. J. Pike, 1977).
[[nodiscard]] Relief crater_relief(const Crater& crater, double x, double y);
/// Half an ellipsoid on the ground.
[[nodiscard]] Relief rock_relief(const Rock& rock, double x, double y);
/// A knob on an elliptical base, with three ledges and blocks that are a seventh of the radius wide.
[[nodiscard]] Relief outcrop_relief(const Outcrop& outcrop, double x, double y);

// Landforms that cover the whole plane: dunes, channels, terraces.

/// Transverse dunes; the lee side is the steep one (R. A. Bagnold, 1941).
class Dunes {
 public:
  explicit Dunes(const WorldParams& world);

  /// Height in [-dune_height_m / 2, dune_height_m / 2]. `albedo` is the natural logarithm of the factor here; crests
  /// are brighter. `warp` bends the crests and `vigour` varies the height; both are noise in [-1, 1] with wavelengths
  /// much longer than a dune.
  [[nodiscard]] Relief relief(double x, double y, double warp, double vigour) const;
  /// Wavelength of the noise for `warp` and `vigour`.
  [[nodiscard]] double warp_wavelength_m() const { return 5 * wavelength_m_; }

 private:
  double height_m_, wavelength_m_;
  double wind_x_, wind_y_;  // unit vector over the wavelength
  double crest_;            // position of the crest in a period, 0.5 to 0.9
};

/// Parallel channels with flat floors and smooth banks, each in its own lane. Meanders are about eleven widths long (L.
/// B. Leopold, M. G. Wolman, 1960).
class Channels {
 public:
  Channels(const WorldParams& world, std::uint32_t seed);

  /// Relative depth of a point in a channel: 0 outside, 1 on the floor.
  [[nodiscard]] double depth(double x, double y) const;
  /// Calls visit(x, y) for points in the rectangle on the channels' centre lines, about every `step_m`.
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

/// Transforms a height for layered ground, with a layer every `step_m`: treads keep a part of their slope, and a scarp
/// lies in the middle between two layers. A steepness of 0 changes nothing; 1 makes the scarp a tenth as wide as the
/// slope was.
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
