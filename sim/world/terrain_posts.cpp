#include "sim/world/terrain_posts.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"

namespace ilp::world {
namespace {

constexpr double crater_cell_radii = 3.2;
constexpr double rock_cell_radii = 6;
constexpr double field_cell_radii = 4;
constexpr double outcrop_cell_radii = 4;
constexpr double least_rockiness = -0.2;  // below it the ground has been swept

Octave octave(double wavelength_m, double amplitude, Rng& rng) {
  Octave result;
  result.wavelength_m = wavelength_m;
  result.amplitude = amplitude;
  result.offset_x = rng.uniform();
  result.offset_y = rng.uniform();
  result.seed = rng.next();
  return result;
}

Rectangle extent(const PostGrid& grid) {
  return {grid.first_i * grid.spacing_m, grid.first_j * grid.spacing_m,
          (grid.first_i + grid.columns - 1) * grid.spacing_m, (grid.first_j + grid.rows - 1) * grid.spacing_m};
}

/// Calls visit(index, x, y) for the posts.
template <typename Visit>
void visit_all(const PostGrid& grid, Visit visit) {
  std::size_t at = 0;
  for (std::int32_t j = 0; j < grid.rows; ++j) {
    const double y = (grid.first_j + j) * grid.spacing_m;
    for (std::int32_t i = 0; i < grid.columns; ++i, ++at) visit(at, (grid.first_i + i) * grid.spacing_m, y);
  }
}

/// Adds `relief(x, y)` to the posts within `reach` of (x, y).
template <typename ReliefAt>
void add_relief(Posts& posts, double x, double y, double reach, ReliefAt relief_at) {
  const PostGrid& grid = posts.grid;
  const auto post = [&](double metres) { return static_cast<std::int32_t>(std::floor(metres / grid.spacing_m)); };
  const std::int32_t i0 = std::max(0, post(x - reach) - grid.first_i);
  const std::int32_t i1 = std::min(grid.columns - 1, post(x + reach) + 1 - grid.first_i);
  const std::int32_t j0 = std::max(0, post(y - reach) - grid.first_j);
  const std::int32_t j1 = std::min(grid.rows - 1, post(y + reach) + 1 - grid.first_j);
  for (std::int32_t j = j0; j <= j1; ++j) {
    for (std::int32_t i = i0; i <= i1; ++i) {
      const Relief relief = relief_at((grid.first_i + i) * grid.spacing_m, (grid.first_j + j) * grid.spacing_m);
      const std::size_t at = posts.index(i, j);
      posts.height_m[at] += relief.height_m;
      posts.albedo[at] *= relief.albedo;
    }
  }
}

/// Noise of one dimension in [-1, 1].
double strata_noise(double at, std::uint32_t seed) {
  const std::int32_t layer = floor_to_int(at);
  const double a = lattice_hash(layer, 0, seed);
  const double b = lattice_hash(layer + 1, 0, seed);
  return (a + (b - a) * quintic_fade(at - layer)) * (2.0 / 4294967296.0) - 1;
}

}  // namespace

Ground::Ground(const WorldParams& world) : world_(world) {
  validate(world);
  imported_ = load_ground(world);
  landforms_ = !imported_.heights || world.heightmap_landforms;
  Rng rng(world.seed, 1);
  const double longest = world.longest_wavelength_m;
  for (double wavelength = longest; wavelength >= world.shortest_wavelength_m; wavelength *= 0.5) {
    const double amplitude = 0.5 * world.relief_m * det_pow(wavelength / longest, world.hurst);
    height_octaves_.push_back(octave(wavelength, amplitude, rng));
  }
  // Brightness varies most at the finest scales: the eye of the matcher looks there, and relief rules the others.
  const double coarsest_albedo = 0.4 * longest;
  for (double wavelength = coarsest_albedo; wavelength >= 4 * world.post_spacing_m; wavelength *= 0.5) {
    const double share = 0.3 * (1 - 0.7 * wavelength / coarsest_albedo);
    albedo_octaves_.push_back(octave(wavelength, share * world.albedo_contrast, rng));
  }
  for (int k = 0; k < 6; ++k) {
    const double wavelength = 3.2 * world.post_spacing_m * std::ldexp(1.0, -k);
    detail_octaves_.push_back(octave(wavelength, 0.5 * world.albedo_contrast, rng));
  }
  rockiness_ = octave(0.25 * longest, 1, rng);
  if (world.crater_density > 0) {
    craters_ = size_classes(world.largest_crater_radius_m, world.smallest_crater_radius_m, world.crater_size_exponent,
                            crater_cell_radii, world.crater_density, rng);
  }
  const double fields = world.boulder_field_density;
  const double rocks = std::max(world.rock_density, fields > 0 ? world.boulder_field_rock_density : 0);
  if (rocks > 0) {
    rocks_ = size_classes(world.largest_rock_radius_m, world.smallest_rock_radius_m, world.rock_size_exponent,
                          rock_cell_radii, rocks, rng);
  }
  // Streams of their own: a landform that is switched on leaves the others where they were.
  if (fields > 0) {
    Rng own(world.seed, 11);
    const double radius = world.boulder_field_radius_m;
    boulder_fields_ = size_classes(radius, radius, 2, field_cell_radii, fields, own);
    for (int layer = 1; layer < world.boulder_field_layers; ++layer) {
      const std::vector<SizeClass> more =
          size_classes(world.largest_rock_radius_m, world.smallest_rock_radius_m, world.rock_size_exponent,
                       rock_cell_radii, world.boulder_field_rock_density, own);
      field_rocks_.insert(field_rocks_.end(), more.begin(), more.end());
    }
  }
  if (world.dune_height_m > 0) {
    Rng own(world.seed, 12);
    dunes_.emplace(world);
    dune_warp_ = octave(dunes_->warp_wavelength_m(), 1, own);
    dune_vigour_ = octave(dunes_->warp_wavelength_m(), 1, own);
  }
  if (world.channel_depth_m > 0) channels_.emplace(world, Rng(world.seed, 13).next());
  if (world.outcrop_density > 0) {
    Rng own(world.seed, 15);
    outcrops_ =
        size_classes(world.outcrop_radius_m, world.outcrop_radius_m, 2, outcrop_cell_radii, world.outcrop_density, own);
  }
  strata_seed_ = Rng(world.seed, 14).next();
  shore_x_ = det_cos(world.shore_direction_rad);
  shore_y_ = det_sin(world.shore_direction_rad);
  set_bounds();
}

void Ground::set_bounds() {
  const WorldParams& w = world_;
  lowest_ = -w.relief_m;
  highest_ = w.relief_m;
  if (imported_.heights) {
    lowest_ = imported_.heights->lowest();
    highest_ = imported_.heights->highest();
  }
  if (landforms_) {
    lowest_ -= w.channel_depth_m + 0.5 * w.dune_height_m;
    highest_ += 0.5 * w.dune_height_m;
    if (!craters_.empty()) lowest_ -= 0.4 * w.largest_crater_radius_m;
    if (!outcrops_.empty()) highest_ += Outcrop::highest * w.outcrop_radius_m;
    if (!rocks_.empty()) highest_ += 0.9 * w.largest_rock_radius_m;
  }
  if (w.liquid) {
    lowest_ = std::max(lowest_, w.liquid_level_m);
    highest_ = std::max(highest_, w.liquid_level_m);
  }
}

double Ground::shore(double x, double y) const {
  // Straight near the line, level far from it: the land's relief stays what it was.
  const double distance = shore_x_ * x + shore_y_ * y - world_.shore_distance_m;
  const double bound = 0.5 * world_.relief_m;
  const double rise = world_.shore_slope * distance / bound;
  return bound * rise / (1 + std::fabs(rise));
}

void Ground::add_base(Posts& posts, std::vector<double>& log_albedo) const {
  if (imported_.heights) {
    visit_all(posts.grid,
              [&](std::size_t at, double x, double y) { posts.height_m[at] = imported_.heights->at(x, y); });
  } else {
    for (const Octave& o : height_octaves_) add_octave(o, posts.grid, posts.height_m);
    if (world_.shore_slope > 0) {
      visit_all(posts.grid, [&](std::size_t at, double x, double y) { posts.height_m[at] += shore(x, y); });
    }
  }
  if (!imported_.brightness) {
    for (const Octave& o : albedo_octaves_) add_octave(o, posts.grid, log_albedo);
  }
}

void Ground::add_layers(Posts& posts, std::vector<double>& log_albedo) const {
  const double step = world_.terrace_step_m;
  for (std::size_t k = 0; k < posts.height_m.size(); ++k) {
    posts.height_m[k] = terrace(posts.height_m[k], step, world_.terrace_steepness);
    // Beds of different brightness, seen where a scarp cuts them.
    log_albedo[k] += 0.5 * world_.albedo_contrast * strata_noise(posts.height_m[k] * 5 / step, strata_seed_);
  }
}

void Ground::add_channels(Posts& posts, std::vector<double>& log_albedo) const {
  visit_all(posts.grid, [&](std::size_t at, double x, double y) {
    const double depth = channels_->depth(x, y);
    posts.height_m[at] -= world_.channel_depth_m * depth;
    log_albedo[at] -= 0.3 * world_.albedo_contrast * depth;
  });
}

void Ground::add_dunes(Posts& posts, std::vector<double>& log_albedo) const {
  std::vector<double> warp(posts.height_m.size(), 0.0);
  std::vector<double> vigour(posts.height_m.size(), 0.0);
  add_octave(dune_warp_, posts.grid, warp);
  add_octave(dune_vigour_, posts.grid, vigour);
  visit_all(posts.grid, [&](std::size_t at, double x, double y) {
    const Relief relief = dunes_->relief(x, y, warp[at], vigour[at]);
    posts.height_m[at] += relief.height_m;
    log_albedo[at] += world_.albedo_contrast * relief.albedo;
  });
}

void Ground::add_craters(Posts& posts) const {
  std::vector<Crater> craters;
  for (const SizeClass& size : craters_) find_craters(size, extent(posts.grid), craters);
  for (const Crater& crater : craters) {
    add_relief(posts, crater.x, crater.y, Crater::reach * crater.radius_m,
               [&](double x, double y) { return crater_relief(crater, x, y); });
  }
}

std::vector<Rock> Ground::rocks(const Rectangle& area) const {
  std::vector<Rock> found;
  if (rocks_.empty()) return found;
  std::vector<BoulderField> fields;
  const double reach = rocks_.front().radius_m;
  const Rectangle wide{area.x0 - reach, area.y0 - reach, area.x1 + reach, area.y1 + reach};
  for (const SizeClass& size : boulder_fields_) find_boulder_fields(size, wide, fields);
  const auto in_a_field = [&](const Rock& rock) {
    return std::any_of(fields.begin(), fields.end(),
                       [&](const BoulderField& field) { return field.contains(rock.x, rock.y); });
  };
  for (const SizeClass& size : rocks_) {
    const std::size_t before = found.size();
    find_rocks(size, area, found);
    const auto absent = [&](const Rock& rock) {
      if (in_a_field(rock)) return rock.draw >= size.share * world_.boulder_field_rock_density;
      const double noise =
          value_noise(rock.x / rockiness_.wavelength_m, rock.y / rockiness_.wavelength_m, rockiness_.seed);
      return noise < least_rockiness || rock.draw >= size.share * world_.rock_density;
    };
    found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(before), found.end(), absent), found.end());
  }
  const auto before = static_cast<std::ptrdiff_t>(found.size());
  for (const SizeClass& size : field_rocks_) find_rocks(size, area, found);
  found.erase(std::remove_if(found.begin() + before, found.end(), [&](const Rock& rock) { return !in_a_field(rock); }),
              found.end());
  return found;
}

void Ground::add_rocks(Posts& posts) const {
  for (const Rock& rock : rocks(extent(posts.grid))) {
    add_relief(posts, rock.x, rock.y, rock.reach_m, [&](double x, double y) { return rock_relief(rock, x, y); });
  }
}

void Ground::add_outcrops(Posts& posts) const {
  std::vector<Outcrop> outcrops;
  for (const SizeClass& size : outcrops_) find_outcrops(size, extent(posts.grid), outcrops);
  for (const Outcrop& outcrop : outcrops) {
    add_relief(posts, outcrop.x, outcrop.y, outcrop.radius_m,
               [&](double x, double y) { return outcrop_relief(outcrop, x, y); });
  }
}

void Ground::finish(Posts& posts) const {
  for (std::size_t k = 0; k < posts.height_m.size(); ++k) {
    double& height = posts.height_m[k];
    if (world_.liquid && height <= world_.liquid_level_m) {
      height = world_.liquid_level_m;
      posts.albedo[k] = world_.liquid_albedo * (0.97 + 0.03 * posts.albedo[k]);
    }
    // The sum of octaves could exceed what is promised; adding 0 makes no zero negative.
    height = std::clamp(height, lowest_, highest_) * world_.ruggedness + 0.0;
  }
}

Posts Ground::posts(std::int32_t first_i, std::int32_t first_j, std::int32_t columns, std::int32_t rows) const {
  Posts result;
  result.grid = {first_i, first_j, columns, rows, world_.post_spacing_m};
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  result.height_m.assign(count, 0.0);
  std::vector<double> log_albedo(count, 0.0);
  add_base(result, log_albedo);
  if (landforms_) {
    if (world_.terrace_step_m > 0) add_layers(result, log_albedo);
    if (channels_) add_channels(result, log_albedo);
    if (dunes_) add_dunes(result, log_albedo);
  }
  // Brightness is a product of factors: it cannot become negative, and bright and dark are balanced.
  result.albedo.resize(count);
  for (std::size_t k = 0; k < count; ++k) result.albedo[k] = det_exp(log_albedo[k]);
  if (imported_.brightness) {
    visit_all(result.grid,
              [&](std::size_t at, double x, double y) { result.albedo[at] *= imported_.brightness->at(x, y); });
  }
  if (landforms_) {
    add_craters(result);
    add_outcrops(result);
    add_rocks(result);
  }
  finish(result);
  return result;
}

void Ground::find_scarps(const Rectangle& area, std::vector<PlantedFeature>& out) const {
  // Where a coarse lattice's neighbours lie on different sides of the middle between two layers.
  const double spacing = std::max(4 * world_.post_spacing_m, world_.longest_wavelength_m / 32);
  PostGrid grid;
  grid.spacing_m = spacing;
  grid.first_i = floor_to_int(area.x0 / spacing);
  grid.first_j = floor_to_int(area.y0 / spacing);
  grid.columns = floor_to_int(area.x1 / spacing) + 2 - grid.first_i;
  grid.rows = floor_to_int(area.y1 / spacing) + 2 - grid.first_j;
  Posts posts;
  posts.grid = grid;
  posts.height_m.assign(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows), 0.0);
  std::vector<double> unused(posts.height_m.size(), 0.0);
  add_base(posts, unused);
  const double step = world_.terrace_step_m;
  const auto scarp_between = [&](std::size_t a, std::size_t b, double x, double y, double dx, double dy) {
    const double low = posts.height_m[a] / step + 0.5;
    const double high = posts.height_m[b] / step + 0.5;
    if (std::floor(low) == std::floor(high)) return;
    const double middle = std::floor(std::max(low, high));
    const double share = (middle - low) / (high - low);
    out.push_back({FeatureKind::scarp, x + share * dx, y + share * dy, 0.5 * spacing, step * world_.ruggedness});
  };
  for (std::int32_t j = 0; j + 1 < grid.rows; ++j) {
    for (std::int32_t i = 0; i + 1 < grid.columns; ++i) {
      const double x = (grid.first_i + i) * spacing;
      const double y = (grid.first_j + j) * spacing;
      scarp_between(posts.index(i, j), posts.index(i + 1, j), x, y, spacing, 0);
      scarp_between(posts.index(i, j), posts.index(i, j + 1), x, y, 0, spacing);
    }
  }
}

std::vector<PlantedFeature> Ground::features(const Rectangle& area) const {
  std::vector<PlantedFeature> found;
  if (!landforms_) return found;
  const auto reaches = [&](const PlantedFeature& feature) {
    const double dx = std::max({area.x0 - feature.x, 0.0, feature.x - area.x1});
    const double dy = std::max({area.y0 - feature.y, 0.0, feature.y - area.y1});
    return dx * dx + dy * dy <= feature.radius_m * feature.radius_m;
  };
  const auto keep = [&](const PlantedFeature& feature) {
    if (reaches(feature)) found.push_back(feature);
  };
  std::vector<Crater> craters;
  for (const SizeClass& size : craters_) find_craters(size, area, craters);
  const double rugged = world_.ruggedness;
  for (const Crater& crater : craters) {
    const double relief = 0.48 * crater.radius_m * crater.freshness;
    keep({FeatureKind::crater, crater.x, crater.y, crater.radius_m, relief * rugged});
  }
  std::vector<BoulderField> fields;
  for (const SizeClass& size : boulder_fields_) find_boulder_fields(size, area, fields);
  for (const BoulderField& field : fields) {
    keep({FeatureKind::boulder_field, field.x, field.y, field.radius_m, 0.65 * world_.largest_rock_radius_m * rugged});
  }
  std::vector<Outcrop> outcrops;
  for (const SizeClass& size : outcrops_) find_outcrops(size, area, outcrops);
  for (const Outcrop& outcrop : outcrops) {
    keep({FeatureKind::outcrop, outcrop.x, outcrop.y, outcrop.radius_m, outcrop.height_m * rugged});
  }
  for (const Rock& rock : rocks(area)) {
    keep({FeatureKind::rock, rock.x, rock.y, rock.reach_m, rock.height_m * rugged});
  }
  if (channels_) {
    channels_->visit_centre_lines(area, world_.channel_width_m, [&](double x, double y) {
      keep({FeatureKind::channel, x, y, 0.5 * world_.channel_width_m, world_.channel_depth_m * rugged});
    });
  }
  if (world_.terrace_step_m > 0) {
    std::vector<PlantedFeature> scarps;
    find_scarps(area, scarps);
    for (const PlantedFeature& scarp : scarps) keep(scarp);
  }
  return found;
}

}  // namespace ilp::world
