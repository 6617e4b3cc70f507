#include "sim/world/terrain.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/world/sun.hpp"

namespace ilp::world {
namespace {

// Squares of a plane that are made once and kept while they are in use: the least recently used go first.

struct TileAddress {
  std::int32_t i = 0, j = 0;
  bool operator==(const TileAddress&) const = default;
  auto operator<=>(const TileAddress&) const = default;
};

/// Safe to use from several threads: two that want the same tile wait for one that makes it.
template <typename Tile>
class TileCache {
 public:
  explicit TileCache(std::size_t capacity) : capacity_(capacity) {}

  /// The tile, made by `make(address)` if it is not there. Stays valid as long as it is held.
  template <typename Make>
  [[nodiscard]] std::shared_ptr<const Tile> get(TileAddress address, Make make) {
    const std::shared_ptr<Slot> slot = find(address);
    std::call_once(slot->once, [&] { slot->tile = make(address); });
    return {slot, &slot->tile};
  }

 private:
  struct Slot {
    std::once_flag once;
    Tile tile;
  };
  struct Entry {
    std::shared_ptr<Slot> slot;
    typename std::list<TileAddress>::iterator age;
  };

  std::shared_ptr<Slot> find(TileAddress address) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(address);
    if (found != entries_.end()) {
      ages_.splice(ages_.begin(), ages_, found->second.age);
      return found->second.slot;
    }
    if (entries_.size() >= capacity_) {
      entries_.erase(ages_.back());
      ages_.pop_back();
    }
    ages_.push_front(address);
    auto slot = std::make_shared<Slot>();
    entries_.emplace(address, Entry{slot, ages_.begin()});
    return slot;
  }

  std::size_t capacity_;
  std::mutex mutex_;
  std::list<TileAddress> ages_;  // the youngest first
  std::map<TileAddress, Entry> entries_;
};

constexpr std::int32_t side = 128;          // posts of a tile
constexpr std::size_t tiles_kept = 512;     // of each kind
constexpr double farthest_post = 1 << 30U;  // leaves room for margins in 32 bits
constexpr double most_posts = 1 << 26U;

struct BareTile {
  std::vector<float> height_m, albedo;
};
struct LitTile {
  std::shared_ptr<const BareTile> bare;
  std::vector<float> radiance;
};

constexpr std::int32_t tile_of(std::int32_t post) {
  return post >= 0 ? post / side : -((side - 1 - post) / side);
}

/// Calls visit(address, i0, i1, j0, j1) for the tiles that hold posts of the grid; [i0, i1) x [j0, j1) are the posts.
template <typename Visit>
void visit_tiles(std::int32_t first_i, std::int32_t first_j, std::int32_t columns, std::int32_t rows, Visit visit) {
  for (std::int32_t tj = tile_of(first_j); tj <= tile_of(first_j + rows - 1); ++tj) {
    for (std::int32_t ti = tile_of(first_i); ti <= tile_of(first_i + columns - 1); ++ti) {
      visit(TileAddress{ti, tj}, std::max(first_i, ti * side), std::min(first_i + columns, (ti + 1) * side),
            std::max(first_j, tj * side), std::min(first_j + rows, (tj + 1) * side));
    }
  }
}

std::ptrdiff_t in_tile(TileAddress address, std::int32_t i, std::int32_t j) {
  return static_cast<std::ptrdiff_t>(j - address.j * side) * side + (i - address.i * side);
}

std::int32_t post_at(double metres, double spacing) {
  const double post = std::floor(metres / spacing);
  if (!(std::fabs(post) < farthest_post)) {
    throw std::runtime_error("terrain: a place " + std::to_string(metres) +
                             " m from the origin lies beyond the edge of " + "a world with posts every " +
                             std::to_string(spacing) + " m");
  }
  return static_cast<std::int32_t>(post);
}

}  // namespace

struct Terrain::Tiles {
  explicit Tiles(const Sunlight& light) : sun(light) {}

  Sunlight sun;
  TileCache<BareTile> bare{tiles_kept};
  TileCache<LitTile> lit{tiles_kept};

  std::shared_ptr<const BareTile> bare_tile(const Ground& ground, TileAddress address) {
    return bare.get(address, [&](TileAddress at) {
      const Posts posts = ground.posts(at.i * side, at.j * side, side, side);
      BareTile tile;
      tile.height_m.assign(posts.height_m.begin(), posts.height_m.end());
      tile.albedo.assign(posts.albedo.begin(), posts.albedo.end());
      return tile;
    });
  }

  /// Heights put together from tiles.
  std::vector<double> heights(const Ground& ground, std::int32_t first_i, std::int32_t first_j, std::int32_t columns,
                              std::int32_t rows) {
    std::vector<double> result(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    visit_tiles(first_i, first_j, columns, rows,
                [&](TileAddress at, std::int32_t i0, std::int32_t i1, std::int32_t j0, std::int32_t j1) {
                  const auto tile = bare_tile(ground, at);
                  for (std::int32_t j = j0; j < j1; ++j) {
                    const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(j - first_j) * columns + (i0 - first_i);
                    std::copy_n(tile->height_m.begin() + in_tile(at, i0, j), i1 - i0, result.begin() + to);
                  }
                });
    return result;
  }

  std::shared_ptr<const LitTile> lit_tile(const Ground& ground, TileAddress address) {
    return lit.get(address, [&](TileAddress at) {
      const PostMargin& margin = sun.margin();
      const std::int32_t columns = margin.left + side + margin.right;
      const std::int32_t rows = margin.below + side + margin.above;
      const std::vector<double> around =
          heights(ground, at.i * side - margin.left, at.j * side - margin.below, columns, rows);
      std::vector<double> direct;
      sun.direct(around, columns, rows, direct);
      LitTile tile;
      tile.bare = bare_tile(ground, at);
      tile.radiance.reserve(direct.size());
      const double ambient = ground.world().ambient;
      for (std::size_t k = 0; k < direct.size(); ++k) {
        const double light = ambient + (1 - ambient) * direct[k];
        tile.radiance.push_back(static_cast<float>(tile.bare->albedo[k] * light));
      }
      return tile;
    });
  }
};

Terrain::Terrain(const WorldParams& params)
    : ground_(params),
      // If everything lies in one plane, heights do not distinguish liquid from land.
      has_liquid_(params.liquid && params.ruggedness > 0),
      liquid_top_(ground_.liquid_surface() +
                  1e-5 * std::max(params.post_spacing_m, std::fabs(ground_.liquid_surface()))),
      tiles_(std::make_unique<Tiles>(Sunlight(params.sun_azimuth_rad, params.sun_elevation_rad, params.post_spacing_m,
                                              ground_.highest() - ground_.lowest()))) {}

Terrain::~Terrain() = default;
Terrain::Terrain(Terrain&&) noexcept = default;
Terrain& Terrain::operator=(Terrain&&) noexcept = default;

double Terrain::height(double x, double y) const {
  const double spacing = params().post_spacing_m;
  const std::int32_t i = post_at(x, spacing);
  const std::int32_t j = post_at(y, spacing);
  const Posts p = ground_.posts(i, j, 2, 2);
  const double u = x / spacing - i;
  const double v = y / spacing - j;
  const auto h = [&](std::size_t k) { return static_cast<double>(static_cast<float>(p.height_m[k])); };
  const double near = h(0) + (h(1) - h(0)) * u;
  const double far = h(2) + (h(3) - h(2)) * u;
  return near + (far - near) * v;
}

Vec3 Terrain::normal(double x, double y) const {
  const double spacing = params().post_spacing_m;
  const double slope_x = (height(x + spacing, y) - height(x - spacing, y)) / (2 * spacing);
  const double slope_y = (height(x, y + spacing) - height(x, y - spacing)) / (2 * spacing);
  return Vec3(-slope_x, -slope_y, 1) / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
}

SurfacePatch Terrain::patch(const Rectangle& area) const {
  const double spacing = params().post_spacing_m;
  SurfacePatch result;
  result.spacing_m = spacing;
  result.first_i = post_at(area.x0, spacing);
  result.first_j = post_at(area.y0, spacing);
  result.columns = post_at(area.x1, spacing) + 2 - result.first_i;
  result.rows = post_at(area.y1, spacing) + 2 - result.first_j;
  const double count = static_cast<double>(result.columns) * result.rows;
  if (result.columns < 2 || result.rows < 2 || count > most_posts) {
    throw std::runtime_error("terrain: a view of " + std::to_string(result.columns) + " x " +
                             std::to_string(result.rows) + " posts; post_spacing_m must suit the altitude");
  }
  result.height_m.resize(static_cast<std::size_t>(count));
  result.radiance.resize(result.height_m.size());
  visit_tiles(result.first_i, result.first_j, result.columns, result.rows,
              [&](TileAddress at, std::int32_t i0, std::int32_t i1, std::int32_t j0, std::int32_t j1) {
                const auto tile = tiles_->lit_tile(ground_, at);
                for (std::int32_t j = j0; j < j1; ++j) {
                  const std::ptrdiff_t from = in_tile(at, i0, j);
                  const auto to = static_cast<std::ptrdiff_t>(result.index(i0 - result.first_i, j - result.first_j));
                  std::copy_n(tile->bare->height_m.begin() + from, i1 - i0, result.height_m.begin() + to);
                  std::copy_n(tile->radiance.begin() + from, i1 - i0, result.radiance.begin() + to);
                }
              });
  return result;
}

}  // namespace ilp::world
