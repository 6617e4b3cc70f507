#include "sim/world/ray_cast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ilp::world {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Steps through the cells of a square lattice along one axis.
struct Axis {
  std::int32_t cell;
  std::int32_t step;
  double next;   // t at the border ahead
  double pitch;  // t between borders
};

/// The cell at t, kept in [first, last]: rounding may put an entry a hair outside. `per_direction` is 1 / direction.
Axis start(double origin, double direction, double per_direction, double t, std::int32_t side, std::int32_t first,
           std::int32_t last) {
  const double position = std::clamp<double>((origin + t * direction) / side, first, last);
  Axis axis{std::clamp(floor_to_int(position), first, last), 0, never, never};
  if (direction > 0) {
    axis.step = 1;
    axis.next = ((axis.cell + 1) * side - origin) * per_direction;
    axis.pitch = side * per_direction;
  } else if (direction < 0) {
    axis.step = -1;
    axis.next = (axis.cell * side - origin) * per_direction;
    axis.pitch = -side * per_direction;
  }
  return axis;
}

void advance(Axis& axis) {
  axis.cell += axis.step;
  axis.next += axis.pitch;
}

std::size_t at(std::int32_t i, std::int32_t j, std::int32_t columns) {
  return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
}

constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr GroundBounds nothing{infinite, -infinite, infinite, -infinite, infinite, -infinite};

GroundBounds unite(const GroundBounds& a, const GroundBounds& b) {
  return {std::min(a.low, b.low),       std::max(a.high, b.high),   std::min(a.x_low, b.x_low),
          std::max(a.x_high, b.x_high), std::min(a.y_low, b.y_low), std::max(a.y_high, b.y_high)};
}

/// Height above the ground along a ray near square (i, j): c + b s + a s^2, with s = t - t0; (u, v) is the place in the
/// square at t0.
struct Clearance {
  double a, b, c, u, v;
};

Clearance clearance(const SurfacePatch& patch, const LatticeRay& ray, std::int32_t i, std::int32_t j, double t0) {
  const float* const near = patch.height_m.data() + patch.index(i, j);
  const float* const far = near + patch.columns;
  const double h00 = near[0];
  const double h01 = far[0];
  // h = h00 + p u + q v + r u v
  const double p = near[1] - h00;
  const double q = h01 - h00;
  const double r = far[1] - h01 - p;
  Clearance result{};
  result.u = ray.x + t0 * ray.dx - i;
  result.v = ray.y + t0 * ray.dy - j;
  result.c = ray.z + t0 * ray.dz - (h00 + p * result.u + q * result.v + r * result.u * result.v);
  result.b = ray.dz - (p * ray.dx + q * ray.dy + r * (result.u * ray.dy + result.v * ray.dx));
  result.a = -r * ray.dx * ray.dy;
  return result;
}

}  // namespace

RayCaster::RayCaster(const SurfacePatch& patch) : patch_(patch) {
  Level base{(patch.columns - 2) / block_side + 1, (patch.rows - 2) / block_side + 1, {}};
  base.blocks.reserve(static_cast<std::size_t>(base.columns) * static_cast<std::size_t>(base.rows));
  for (std::int32_t j = 0; j < base.rows; ++j) {
    for (std::int32_t i = 0; i < base.columns; ++i) base.blocks.push_back(bounds_of_block(i, j));
  }
  levels_.push_back(std::move(base));
  while (levels_.back().columns > 1 || levels_.back().rows > 1) {
    const Level& fine = levels_.back();
    Level coarse{(fine.columns + 1) / 2, (fine.rows + 1) / 2, {}};
    coarse.blocks.reserve(static_cast<std::size_t>(coarse.columns) * static_cast<std::size_t>(coarse.rows));
    for (std::int32_t j = 0; j < coarse.rows; ++j) {
      for (std::int32_t i = 0; i < coarse.columns; ++i) {
        GroundBounds bounds = nothing;
        for (std::int32_t fj = 2 * j; fj < std::min(2 * j + 2, fine.rows); ++fj) {
          for (std::int32_t fi = 2 * i; fi < std::min(2 * i + 2, fine.columns); ++fi) {
            bounds = unite(bounds, fine.blocks[at(fi, fj, fine.columns)]);
          }
        }
        coarse.blocks.push_back(bounds);
      }
    }
    levels_.push_back(std::move(coarse));
  }
  low_ = levels_.back().blocks[0].low;
  top_ = levels_.back().blocks[0].high;
}

GroundBounds RayCaster::bounds_of_block(std::int32_t block_i, std::int32_t block_j) const {
  const std::int32_t i0 = block_i * block_side;
  const std::int32_t i1 = std::min(i0 + block_side, patch_.columns - 1);
  const std::int32_t j1 = std::min((block_j + 1) * block_side, patch_.rows - 1);
  GroundBounds bounds = nothing;
  for (std::int32_t j = block_j * block_side; j <= j1; ++j) {
    const float* const h = patch_.height_m.data() + patch_.index(0, j);
    for (std::int32_t i = i0; i <= i1; ++i) {
      bounds.low = std::min(bounds.low, h[i]);
      bounds.high = std::max(bounds.high, h[i]);
    }
    // The slopes of a bilinear square lie between those of its edges.
    for (std::int32_t i = i0; i < i1; ++i) {
      bounds.x_low = std::min(bounds.x_low, h[i + 1] - h[i]);
      bounds.x_high = std::max(bounds.x_high, h[i + 1] - h[i]);
    }
    if (j == j1) break;
    for (std::int32_t i = i0; i <= i1; ++i) {
      bounds.y_low = std::min(bounds.y_low, h[i + patch_.columns] - h[i]);
      bounds.y_high = std::max(bounds.y_high, h[i + patch_.columns] - h[i]);
    }
  }
  return bounds;
}

GroundBounds RayCaster::bounds_of(const Squares& squares) const {
  std::size_t level = 0;
  std::int32_t shift = block_shift;
  while (level + 1 < levels_.size() &&
         std::max((squares.i1 >> shift) - (squares.i0 >> shift), (squares.j1 >> shift) - (squares.j0 >> shift)) > 3) {
    ++level;
    ++shift;
  }
  const Level& blocks = levels_[level];
  GroundBounds bounds = nothing;
  for (std::int32_t j = squares.j0 >> shift; j <= squares.j1 >> shift; ++j) {
    for (std::int32_t i = squares.i0 >> shift; i <= squares.i1 >> shift; ++i) {
      bounds = unite(bounds, blocks.blocks[at(i, j, blocks.columns)]);
    }
  }
  return bounds;
}

RayCaster::Squares RayCaster::squares_below(std::span<const LatticeRay> outer, double near, double far) const {
  double x0 = never, x1 = -never, y0 = never, y1 = -never;
  for (const LatticeRay& ray : outer) {
    for (const double t : {near, far}) {
      x0 = std::min(x0, ray.x + t * ray.dx);
      x1 = std::max(x1, ray.x + t * ray.dx);
      y0 = std::min(y0, ray.y + t * ray.dy);
      y1 = std::max(y1, ray.y + t * ray.dy);
    }
  }
  const auto column = [&](double x) { return static_cast<std::int32_t>(std::clamp<double>(x, 0, patch_.columns - 2)); };
  const auto row = [&](double y) { return static_cast<std::int32_t>(std::clamp<double>(y, 0, patch_.rows - 2)); };
  return {column(x0), row(y0), column(x1), row(y1)};
}

HitInterval RayCaster::narrow(std::span<const LatticeRay> outer) const {
  HitInterval result{0, never, false};
  double low = low_, high = top_;
  GroundBounds bounds = nothing;
  // What lies below the interval bounds the heights, and these bound the interval.
  for (int round = 0; round < 8; ++round) {
    double near = never, far = 0;
    for (const LatticeRay& ray : outer) {
      near = std::min(near, (high - ray.z) / ray.dz);
      far = std::max(far, (low - ray.z) / ray.dz);
    }
    constexpr double slack = 1e-9;
    near = std::max(result.near, near - slack * far);
    far = std::min(result.far, far + slack * far);
    const bool settled = far - near > 0.8 * (result.far - result.near);
    result.near = near;
    result.far = far;
    bounds = bounds_of(squares_below(outer, near, far));
    low = bounds.low;
    high = bounds.high;
    if (settled) break;
  }
  // Single: along every ray, the height above any such slope falls.
  result.single = true;
  for (const LatticeRay& ray : outer) {
    const double fall = ray.dz + std::max(-bounds.x_low * ray.dx, -bounds.x_high * ray.dx) +
                        std::max(-bounds.y_low * ray.dy, -bounds.y_high * ray.dy);
    result.single = result.single && fall < 1e-6 * ray.dz;
  }
  return result;
}

double RayCaster::hit(const LatticeRay& ray, const HitInterval& interval, double guess) const {
  if (interval.single) {
    double t = std::clamp(guess, interval.near, interval.far);
    // Newton's method, with a whole square in place of the tangent.
    for (int step = 0; step < 6; ++step) {
      const std::int32_t i = std::clamp(static_cast<std::int32_t>(ray.x + t * ray.dx), 0, patch_.columns - 2);
      const std::int32_t j = std::clamp(static_cast<std::int32_t>(ray.y + t * ray.dy), 0, patch_.rows - 2);
      const Clearance over = clearance(patch_, ray, i, j, t);
      const double discriminant = over.b * over.b - 4 * over.a * over.c;
      if (over.b >= 0 || discriminant < 0) break;
      const double s = 2 * over.c / (std::sqrt(discriminant) - over.b);
      t += s;
      const double u = over.u + s * ray.dx;
      const double v = over.v + s * ray.dy;
      constexpr double edge = 1e-9;  // of a square's side, where the surface is continuous
      if (u >= -edge && u <= 1 + edge && v >= -edge && v <= 1 + edge) return t;
    }
  }
  return hit_after(interval.near, ray);
}

double RayCaster::hit_in_square(const LatticeRay& ray, std::int32_t i, std::int32_t j, double t0, double t1) const {
  const auto [a, b, c, u, v] = clearance(patch_, ray, i, j, t0);
  if (c <= 0) return t0;
  const double discriminant = b * b - 4 * a * c;
  if (b >= 0 && a >= 0) return -1;
  if (discriminant < 0) return -1;
  // c > 0: the nearer root in front, written without cancellation.
  const double root = std::sqrt(discriminant);
  const double s = b < 0 ? 2 * c / (root - b) : (-b - root) / (2 * a);
  return s >= 0 && s <= t1 - t0 ? t0 + s : -1;
}

double RayCaster::hit_in_block(const LatticeRay& ray, const std::array<double, 2>& per_direction, std::int32_t block_i,
                               std::int32_t block_j, double t0, double t1) const {
  const std::int32_t i0 = block_i * block_side;
  const std::int32_t j0 = block_j * block_side;
  const std::int32_t i1 = std::min(i0 + block_side, patch_.columns - 1) - 1;
  const std::int32_t j1 = std::min(j0 + block_side, patch_.rows - 1) - 1;
  Axis x = start(ray.x, ray.dx, per_direction[0], t0, 1, i0, i1);
  Axis y = start(ray.y, ray.dy, per_direction[1], t0, 1, j0, j1);
  double t = t0;
  while (x.cell >= i0 && x.cell <= i1 && y.cell >= j0 && y.cell <= j1) {
    const double exit = std::min(std::min(x.next, y.next), t1);
    if (exit >= t) {
      const double found = hit_in_square(ray, x.cell, y.cell, t, exit);
      if (found >= 0) return found;
      t = exit;
    }
    if (exit >= t1) break;
    advance(x.next < y.next ? x : y);
  }
  return -1;
}

double RayCaster::hit_after(double t, const LatticeRay& ray) const {
  const Level& blocks = levels_.front();
  const std::array<double, 2> per_direction = {1 / ray.dx, 1 / ray.dy};
  Axis x = start(ray.x, ray.dx, per_direction[0], t, block_side, -1, blocks.columns);
  Axis y = start(ray.y, ray.dy, per_direction[1], t, block_side, -1, blocks.rows);
  while (x.cell >= 0 && x.cell < blocks.columns && y.cell >= 0 && y.cell < blocks.rows) {
    const double exit = std::min(x.next, y.next);
    if (ray.z + exit * ray.dz <= blocks.blocks[at(x.cell, y.cell, blocks.columns)].high) {
      const double found = hit_in_block(ray, per_direction, x.cell, y.cell, t, exit);
      if (found >= 0) return found;
    }
    if (exit == never) return -1;
    t = exit;
    advance(x.next < y.next ? x : y);
  }
  return -1;
}

double RayCaster::hit(const Vec3& origin, const Vec3& direction) const {
  const double scale = 1 / patch_.spacing_m;
  return hit(LatticeRay{origin.x() * scale - patch_.first_i, origin.y() * scale - patch_.first_j, origin.z(),
                        direction.x() * scale, direction.y() * scale, direction.z()});
}

}  // namespace ilp::world
