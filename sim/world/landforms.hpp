// Craters, rocks, boulder fields and outcrops, scattered over the plane without end: every square of a size class's own
// lattice holds at most one, decided by a hash of the square.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/rng.hpp"

namespace ilp::world {

struct Rectangle {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< m
};

/// One size class: landforms with radii between half of `radius_m` and `radius_m`; the number larger than r falls as
/// r^-exponent.
struct SizeClass {
  double radius_m = 0;
  double cell_m = 0;       ///< side of the lattice's squares
  double probability = 0;  ///< that a square holds one
  std::uint32_t seed = 0;
  double exponent = 2;
  double share = 1;  ///< of the density that was asked for: less where the exponent wants fewer
};

/// The classes from `largest_m` down to `smallest_m`, each half as large as the previous, `cell_radii` times their
/// radius apart. Together they follow the exponent; the class that it makes the most crowded has `density`.
[[nodiscard]] std::vector<SizeClass> size_classes(double largest_m, double smallest_m, double exponent,
                                                  double cell_radii, double density, Rng& rng);

struct Crater {
  double x = 0, y = 0;  ///< centre, m
  double radius_m = 0;
  double freshness = 0;  ///< 0 worn, 1 new

  static constexpr double reach = 2.5;  ///< radii; the ejecta blanket ends here
};

struct Rock {
  double x = 0, y = 0;                          ///< centre, m
  double axis_x_per_m = 0, axis_y_per_m = 0;    ///< first principal direction, divided by its half-length
  double cross_x_per_m = 0, cross_y_per_m = 0;  ///< second one
  double reach_m = 0;
  double height_m = 0;
  double albedo = 1;
  double draw = 0;  ///< in [0, probability of its class); those with small ones are the last to leave thinner ground
};

/// Ground with more rocks than elsewhere.
struct BoulderField {
  double x = 0, y = 0;  ///< centre, m
  double radius_m = 0;

  [[nodiscard]] bool contains(double at_x, double at_y) const {
    return (at_x - x) * (at_x - x) + (at_y - y) * (at_y - y) < radius_m * radius_m;
  }
};

/// Bedrock that stands out of the ground: a knob with ledges, broken by joints, of another brightness.
struct Outcrop {
  double x = 0, y = 0;                        ///< centre, m
  double axis_x_per_m = 0, axis_y_per_m = 0;  ///< as of a rock
  double cross_x_per_m = 0, cross_y_per_m = 0;
  double radius_m = 0;  ///< half the longest diameter
  double height_m = 0;
  double albedo = 1;
  std::uint32_t seed = 0;

  static constexpr double highest = 0.35;  ///< times the radius, blocks included
};

/// The landforms of the class that may touch the rectangle, in an order that does not depend on the rectangle.
void find_craters(const SizeClass& size, const Rectangle& area, std::vector<Crater>& out);
void find_rocks(const SizeClass& size, const Rectangle& area, std::vector<Rock>& out);
void find_boulder_fields(const SizeClass& size, const Rectangle& area, std::vector<BoulderField>& out);
void find_outcrops(const SizeClass& size, const Rectangle& area, std::vector<Outcrop>& out);

struct Relief {
  double height_m = 0;
  double albedo = 1;  ///< factor
};

/// Bowl, raised rim and thinning ejecta: depth 0.2 diameters and rim 0.04 diameters when new (R. J. Pike, 1977).
[[nodiscard]] Relief crater_relief(const Crater& crater, double x, double y);
/// Half an ellipsoid on the ground.
[[nodiscard]] Relief rock_relief(const Rock& rock, double x, double y);
/// Three ledges on a half ellipse, blocks a seventh of the radius wide on top of them.
[[nodiscard]] Relief outcrop_relief(const Outcrop& outcrop, double x, double y);

}  // namespace ilp::world
