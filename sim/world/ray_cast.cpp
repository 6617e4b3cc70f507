#include "sim/world/ray_cast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp::sim {
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

}  // namespace

struct RayCaster::Ray {
  double x, y, z;     // of the origin: posts from the patch's first one, metres
  double dx, dy, dz;  // per t
  double per_dx, per_dy;
};

RayCaster::RayCaster(const SurfacePatch& patch) : patch_(patch) {
  block_columns_ = (patch.columns - 1 + block_side - 1) / block_side;
  block_rows_ = (patch.rows - 1 + block_side - 1) / block_side;
  block_top_.reserve(static_cast<std::size_t>(block_columns_) * static_cast<std::size_t>(block_rows_));
  float top = -std::numeric_limits<float>::infinity();
  for (std::int32_t bj = 0; bj < block_rows_; ++bj) {
    for (std::int32_t bi = 0; bi < block_columns_; ++bi) {
      float block_top = -std::numeric_limits<float>::infinity();
      const std::int32_t j1 = std::min((bj + 1) * block_side, patch.rows - 1);
      const std::int32_t i1 = std::min((bi + 1) * block_side, patch.columns - 1);
      for (std::int32_t j = bj * block_side; j <= j1; ++j) {
        for (std::int32_t i = bi * block_side; i <= i1; ++i) {
          block_top = std::max(block_top, patch.height_m[patch.index(i, j)]);
        }
      }
      block_top_.push_back(block_top);
      top = std::max(top, block_top);
    }
  }
  top_ = top;
}

double RayCaster::hit_in_square(const Ray& ray, std::int32_t i, std::int32_t j, double t0, double t1) const {
  const std::size_t at = patch_.index(i, j);
  const double h00 = patch_.height_m[at];
  const double h10 = patch_.height_m[at + 1];
  const double h01 = patch_.height_m[at + static_cast<std::size_t>(patch_.columns)];
  const double h11 = patch_.height_m[at + static_cast<std::size_t>(patch_.columns) + 1];
  // Height above ground along the ray: c + b s + a s^2, s = t - t0, from h = h00 + p u + q v + r u v.
  const double p = h10 - h00;
  const double q = h01 - h00;
  const double r = h11 - h10 - q;
  const double u = ray.x + t0 * ray.dx - i;
  const double v = ray.y + t0 * ray.dy - j;
  const double c = ray.z + t0 * ray.dz - (h00 + p * u + q * v + r * u * v);
  if (c <= 0) return t0;
  const double b = ray.dz - (p * ray.dx + q * ray.dy + r * (u * ray.dy + v * ray.dx));
  const double a = -r * ray.dx * ray.dy;
  const double discriminant = b * b - 4 * a * c;
  if (b >= 0 && a >= 0) return -1;
  if (discriminant < 0) return -1;
  // c > 0: the nearer root in front, written without cancellation.
  const double root = std::sqrt(discriminant);
  const double s = b < 0 ? 2 * c / (root - b) : (-b - root) / (2 * a);
  return s >= 0 && s <= t1 - t0 ? t0 + s : -1;
}

double RayCaster::hit_in_block(const Ray& ray, std::int32_t block_i, std::int32_t block_j, double t0, double t1) const {
  const std::int32_t i0 = block_i * block_side;
  const std::int32_t j0 = block_j * block_side;
  const std::int32_t i1 = std::min(i0 + block_side, patch_.columns - 1) - 1;
  const std::int32_t j1 = std::min(j0 + block_side, patch_.rows - 1) - 1;
  Axis x = start(ray.x, ray.dx, ray.per_dx, t0, 1, i0, i1);
  Axis y = start(ray.y, ray.dy, ray.per_dy, t0, 1, j0, j1);
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

double RayCaster::hit(const Vec3& origin, const Vec3& direction) const {
  if (!(direction.z() < 0)) return -1;
  const double scale = 1 / patch_.spacing_m;
  Ray ray{};
  ray.x = origin.x() * scale - patch_.first_i;
  ray.y = origin.y() * scale - patch_.first_j;
  ray.z = origin.z();
  ray.dx = direction.x() * scale;
  ray.dy = direction.y() * scale;
  ray.dz = direction.z();
  ray.per_dx = 1 / ray.dx;
  ray.per_dy = 1 / ray.dy;
  double t = (top_ - ray.z) / ray.dz;
  Axis x = start(ray.x, ray.dx, ray.per_dx, t, block_side, -1, block_columns_);
  Axis y = start(ray.y, ray.dy, ray.per_dy, t, block_side, -1, block_rows_);
  while (x.cell >= 0 && x.cell < block_columns_ && y.cell >= 0 && y.cell < block_rows_) {
    const double exit = std::min(x.next, y.next);
    const double block_top = block_top_[static_cast<std::size_t>(y.cell) * static_cast<std::size_t>(block_columns_) +
                                        static_cast<std::size_t>(x.cell)];
    if (ray.z + exit * ray.dz <= block_top) {
      const double found = hit_in_block(ray, x.cell, y.cell, t, exit);
      if (found >= 0) return found;
    }
    if (exit == never) return -1;
    t = exit;
    advance(x.next < y.next ? x : y);
  }
  return -1;
}

}  // namespace ilp::sim
