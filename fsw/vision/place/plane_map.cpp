#include "fsw/vision/place/plane_map.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/image/small_solver.hpp"

namespace ilp {

/// About the mean of the points.
struct PlaneFit::Moments {
  double xa, ya, xb, yb;  ///< means
  double xx, xy, yy;      ///< of image a
  double ux, uy, vx, vy;  ///< (u, v) of image b with (x, y) of image a
};

void PlaneFit::add(double xa, double ya, double xb, double yb) {
  const double x = (xa - origin_x_) / unit_, y = (ya - origin_y_) / unit_;
  const double u = (xb - origin_x_) / unit_, v = (yb - origin_y_) / unit_;
  ++count_;
  a_[0] += x;
  a_[1] += y;
  b_[0] += u;
  b_[1] += v;
  aa_[0] += x * x;
  aa_[1] += x * y;
  aa_[2] += y * y;
  ab_[0] += u * x;
  ab_[1] += u * y;
  ab_[2] += v * x;
  ab_[3] += v * y;
  const double rows[2][8] = {{x, y, 1, 0, 0, 0, -u * x, -u * y}, {0, 0, 0, x, y, 1, -v * x, -v * y}};
  const double values[2] = {u, v};
  for (int r = 0; r < 2; ++r) {
    for (int i = 0; i < 8; ++i) {
      rhs_[i] += rows[r][i] * values[r];
      for (int k = 0; k <= i; ++k) normal_[i][k] += rows[r][i] * rows[r][k];
    }
  }
}

PlaneFit::Moments PlaneFit::moments() const {
  const auto n = static_cast<double>(count_);
  const double xa = a_[0] / n, ya = a_[1] / n, xb = b_[0] / n, yb = b_[1] / n;
  return {xa,
          ya,
          xb,
          yb,
          aa_[0] / n - xa * xa,
          aa_[1] / n - xa * ya,
          aa_[2] / n - ya * ya,
          ab_[0] / n - xb * xa,
          ab_[1] / n - xb * ya,
          ab_[2] / n - yb * xa,
          ab_[3] / n - yb * ya};
}

// From the fit's own coordinates to pixels.
void PlaneFit::set(const double (&h)[8], PlaneMap& map) const {
  const double x = origin_x_, y = origin_y_, s = unit_;
  // Rows of h in pixels of image a: h (p - origin) / unit.
  double row[3][3];
  for (std::size_t r = 0; r < 3; ++r) {
    const double hx = h[3 * r] / s, hy = h[3 * r + 1] / s, one = r < 2 ? h[3 * r + 2] : 1;
    row[r][0] = hx;
    row[r][1] = hy;
    row[r][2] = one - hx * x - hy * y;
  }
  for (int k = 0; k < 3; ++k) {
    row[0][k] = s * row[0][k] + x * row[2][k];
    row[1][k] = s * row[1][k] + y * row[2][k];
  }
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) map.h[3 * r + k] = row[r][k] / row[2][2];
  }
}

bool PlaneFit::similarity(PlaneMap& map) const {
  if (count_ < 2) return false;
  const Moments m = moments();
  const double spread = m.xx + m.yy;
  if (!(spread > 1e-6)) return false;
  const double re = (m.ux + m.vy) / spread, im = (m.vx - m.uy) / spread;
  if (!(re * re + im * im > 0)) return false;
  set({re, -im, m.xb - re * m.xa + im * m.ya, im, re, m.yb - im * m.xa - re * m.ya, 0, 0}, map);
  return true;
}

bool PlaneFit::affine(PlaneMap& map) const {
  if (count_ < 3) return false;
  const Moments m = moments();
  const double det = m.xx * m.yy - m.xy * m.xy;
  if (!(det > 1e-9)) return false;
  const double a = (m.ux * m.yy - m.uy * m.xy) / det, b = (m.uy * m.xx - m.ux * m.xy) / det;
  const double c = (m.vx * m.yy - m.vy * m.xy) / det, d = (m.vy * m.xx - m.vx * m.xy) / det;
  set({a, b, m.xb - a * m.xa - b * m.ya, c, d, m.yb - c * m.xa - d * m.ya, 0, 0}, map);
  return true;
}

bool PlaneFit::homography(PlaneMap& map) const {
  if (count_ < 4) return false;
  double a[8][8], h[8];
  for (int i = 0; i < 8; ++i) {
    std::copy_n(normal_[i], 8, a[i]);
    h[i] = rhs_[i];
  }
  if (!factor_positive_definite<8>(a, 1e-8)) return false;
  solve_factored<8>(a, h);
  PlaneMap found;
  set(h, found);
  // A horizon among the points is none of a camera that looks down.
  for (const double& value : found.h) {
    if (!std::isfinite(value)) return false;
  }
  map = found;
  return true;
}

double PlaneFit::least_spread_px() const {
  if (count_ < 2) return 0;
  const Moments m = moments();
  const double mean = 0.5 * (m.xx + m.yy), half = 0.5 * (m.xx - m.yy);
  return unit_ * std::sqrt(std::max(mean - std::sqrt(half * half + m.xy * m.xy), 0.0));
}

}  // namespace ilp
