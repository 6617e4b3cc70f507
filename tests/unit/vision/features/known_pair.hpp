// Two images of one landscape with an analytic relation: where a point of the first is seen in the second is known.
#pragma once

#include <algorithm>
#include <cmath>

#include "fsw/base/rng.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {

/// The similarity about the centre of a 640x480 image, then a shift.
inline Similarity2 about_centre(double scale, double rotation_rad, double shift_x, double shift_y) {
  Similarity2 s{scale, rotation_rad, 0, 0};
  double x, y;
  apply(s, 319.5, 239.5, x, y);
  s.shift_x_px = 319.5 - x + shift_x;
  s.shift_y_px = 239.5 - y + shift_y;
  return s;
}

/// Row-major, as the matchers take it.
struct Plane {
  double b_from_a[9];
  explicit Plane(const Similarity2& s)
      : b_from_a{s.scale * std::cos(s.rotation_rad),
                 -s.scale * std::sin(s.rotation_rad),
                 s.shift_x_px,
                 s.scale * std::sin(s.rotation_rad),
                 s.scale * std::cos(s.rotation_rad),
                 s.shift_y_px,
                 0,
                 0,
                 1} {}
};

/// Relief: what the similarity predicts is off by up to `amplitude` px, smoothly over the image.
inline double relief(double x, double y, double amplitude) {
  return amplitude * std::sin(x / 70 + 1) * std::cos(y / 90);
}

struct PairOptions {
  double relief_px = 0;
  double gain_a = 1, gain = 1, offset = 0;  ///< grey = clamp(gain * radiance + offset), 0 to 255
  double noise = 1;                         ///< one sigma, grey levels
  double moving_share = 0;                  ///< of image b: squares of 40 px whose texture has moved on its own
};

/// b(p) = gain * a's ground at the place that p looks at. The way back from b to a has the relief, so it is known
/// exactly; the way there is its inverse, by fixed-point iteration.
struct KnownPair {
  static constexpr double moved_x = 7, moved_y = -5;

  Similarity2 b_from_a;
  PairOptions options;
  Image a, b;

  KnownPair(const Similarity2& similarity, const PairOptions& o)
      : b_from_a(similarity), options(o), a(640, 480), b(640, 480) {
    Rng rng(9);
    const auto grey = [&](double value) {
      double gaussian = -6;
      for (int k = 0; k < 12; ++k) gaussian += rng.uniform();
      return static_cast<std::uint8_t>(std::clamp(std::floor(value + o.noise * gaussian + 0.5), 0.0, 255.0));
    };
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        a.view().at(x, y) = grey(o.gain_a * fractal_texture(x + 3000, y + 700, 5, 1));
        double ax, ay;
        const bool moved = moves(x, y);
        a_from_b(x - (moved ? moved_x : 0), y - (moved ? moved_y : 0), ax, ay);
        b.view().at(x, y) = grey(o.gain * fractal_texture(ax + 3000, ay + 700, 5, 1) + o.offset);
      }
    }
  }
  /// Whether the texture seen there in b has moved.
  [[nodiscard]] bool moves(double x, double y) const {
    const auto cell = static_cast<std::uint64_t>(std::floor(x / 40) + 100 * std::floor(y / 40));
    return static_cast<double>(mix64(cell) >> 11U) * 0x1p-53 < options.moving_share;
  }
  void a_from_b(double x, double y, double& ax, double& ay) const {
    apply(inverse(b_from_a), x, y, ax, ay);
    ax += relief(x, y, options.relief_px);
    ay += 0.3 * relief(y, x, options.relief_px);
  }
  void truth(double ax, double ay, double& x, double& y) const {
    apply(b_from_a, ax, ay, x, y);
    for (int k = 0; k < 60; ++k) {
      const double px = ax - relief(x, y, options.relief_px), py = ay - 0.3 * relief(y, x, options.relief_px);
      apply(b_from_a, px, py, x, y);
    }
  }
  [[nodiscard]] double error(double ax, double ay, double xb, double yb) const {
    double x, y;
    truth(ax, ay, x, y);
    return std::hypot(xb - x, yb - y);
  }
  /// Whether a point of a, with the patch around it, is seen in b.
  [[nodiscard]] bool visible(double ax, double ay) const {
    double x, y;
    truth(ax, ay, x, y);
    return x > 12 && y > 12 && x < 627 && y < 467;
  }
};

}  // namespace ilp::test
