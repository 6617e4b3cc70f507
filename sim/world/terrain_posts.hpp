// Computes the unlit ground: heights and brightness at posts, the points of a world-wide lattice.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/world/heightmap.hpp"
#include "sim/world/landforms.hpp"
#include "sim/world/lattice_noise.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

/// Values at the posts of a grid, row by row.
struct Posts {
  PostGrid grid;
  std::vector<double> height_m;
  std::vector<double> albedo;

  [[nodiscard]] std::size_t index(std::int32_t i, std::int32_t j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(i);
  }
};

enum class FeatureKind : std::uint8_t { crater, boulder_field, rock, channel, scarp, outcrop };

/// A feature of the world, as truth for detectors.
struct PlantedFeature {
  FeatureKind kind = FeatureKind::crater;
  double x = 0, y = 0;  ///< centre, m
  double radius_m = 0;  ///< channel: half of its width; scarp: distance within which the scarp passes the point
  double relief_m = 0;  ///< highest minus lowest point; boulder field: relief of its largest boulders
};

class Ground {
 public:
  /// Throws as Terrain's constructor.
  explicit Ground(const WorldParams& world);

  [[nodiscard]] const WorldParams& world() const { return world_; }
  [[nodiscard]] const std::vector<Octave>& detail_octaves() const { return detail_octaves_; }
  /// Bounds of all heights, m.
  [[nodiscard]] double lowest() const { return lowest_ * world_.ruggedness + 0.0; }
  [[nodiscard]] double highest() const { return highest_ * world_.ruggedness; }
  /// Height of the liquid's surface, m. Liquid has no detail.
  [[nodiscard]] double liquid_surface() const { return world_.liquid_level_m * world_.ruggedness; }

  /// Values of the posts of a rectangle of the lattice. A post has the same values in every rectangle.
  [[nodiscard]] Posts posts(std::int32_t first_i, std::int32_t first_j, std::int32_t columns, std::int32_t rows) const;
  /// The features that touch the rectangle, in the order of their kinds. Channels and scarps are given as points along
  /// their lines.
  [[nodiscard]] std::vector<PlantedFeature> features(const Rectangle& area) const;

 private:
  void add_base(Posts& posts, std::vector<double>& log_albedo) const;
  void add_layers(Posts& posts, std::vector<double>& log_albedo) const;
  void add_channels(Posts& posts, std::vector<double>& log_albedo) const;
  void add_dunes(Posts& posts, std::vector<double>& log_albedo) const;
  void add_craters(Posts& posts) const;
  void add_rocks(Posts& posts) const;
  void add_outcrops(Posts& posts) const;
  void finish(Posts& posts) const;
  [[nodiscard]] double shore(double x, double y) const;
  [[nodiscard]] std::vector<Rock> rocks(const Rectangle& area) const;
  void find_scarps(const Rectangle& area, std::vector<PlantedFeature>& out) const;
  void set_bounds();

  WorldParams world_;
  ImportedGround imported_;
  std::vector<Octave> height_octaves_;
  std::vector<Octave> albedo_octaves_;
  std::vector<Octave> detail_octaves_;
  Octave rockiness_;
  std::vector<SizeClass> craters_;
  std::vector<SizeClass> rocks_;
  std::vector<SizeClass> boulder_fields_;
  std::vector<SizeClass> field_rocks_;  // of boulder fields only, beyond the first layer
  std::vector<SizeClass> outcrops_;
  std::optional<Dunes> dunes_;
  Octave dune_warp_, dune_vigour_;
  std::optional<Channels> channels_;
  std::uint32_t strata_seed_ = 0;
  double shore_x_ = 0, shore_y_ = 0;
  bool landforms_ = true;
  double lowest_ = 0, highest_ = 0;  // before ruggedness scales them
};

}  // namespace ilp::world
