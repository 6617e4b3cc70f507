// Maps between two images of a plane, fitted to matched points by least squares: a similarity, which few matches
// determine; an affine map; and a homography, which models the tilt of the cameras.
#pragma once

#include <cstddef>

namespace ilp {

/// Homography b_from_a, row-major, px; the last element is 1.
struct PlaneMap {
  double h[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

  void apply(double x, double y, double& u, double& v) const {
    const double w = h[6] * x + h[7] * y + h[8];
    u = (h[0] * x + h[1] * y + h[2]) / w;
    v = (h[3] * x + h[4] * y + h[5]) / w;
  }
  [[nodiscard]] double squared_distance(double xa, double ya, double xb, double yb) const {
    double u, v;
    apply(xa, ya, u, v);
    return (u - xb) * (u - xb) + (v - yb) * (v - yb);
  }
};

/// Sums over matched points. Each fit returns false, with `map` unchanged, if the points do not determine the map.
class PlaneFit {
 public:
  /// In both images, coordinates are relative to (origin_x, origin_y) and in units of `unit_px`, to keep rounding
  /// errors small. Use the middle of the images and half their width.
  PlaneFit(double origin_x, double origin_y, double unit_px)
      : origin_x_(origin_x), origin_y_(origin_y), unit_(unit_px) {}

  void add(double xa, double ya, double xb, double yb);
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Needs at least two points. A similarity does not mirror.
  [[nodiscard]] bool similarity(PlaneMap& map) const;
  /// Needs at least three points.
  [[nodiscard]] bool affine(PlaneMap& map) const;
  /// Needs at least four points. Minimises the algebraic error, which for cameras that look down is nearly the error in
  /// pixels.
  [[nodiscard]] bool homography(PlaneMap& map) const;
  /// Standard deviation of the points of image a along the direction in which they spread least, px.
  [[nodiscard]] double least_spread_px() const;

 private:
  struct Moments;
  [[nodiscard]] Moments moments() const;
  void set(const double (&h)[8], PlaneMap& map) const;

  double origin_x_, origin_y_, unit_;
  std::size_t count_ = 0;
  double a_[2] = {}, b_[2] = {};            // sums of the coordinates
  double aa_[3] = {}, ab_[4] = {};          // of their products
  double normal_[8][8] = {}, rhs_[8] = {};  // of the homography's equations, lower triangle
};

}  // namespace ilp
