// Similarities about the centres of two images of one size, as complex numbers: z_b = m z_a + d. Halving both images
// halves d and does not change m, so one similarity serves every level of a pyramid.
#pragma once

#include <cmath>

#include "fsw/base/geometry.hpp"
#include "fsw/base/math.hpp"

namespace ilp {

struct CentredSimilarity {
  double m_re = 1, m_im = 0;  ///< scale * exp(i rotation)
  double d_x = 0, d_y = 0;    ///< px of the level

  void apply(double x, double y, double& out_x, double& out_y) const {
    out_x = m_re * x - m_im * y + d_x;
    out_y = m_im * x + m_re * y + d_y;
  }
  [[nodiscard]] double scale() const { return std::sqrt(m_re * m_re + m_im * m_im); }
  [[nodiscard]] double rotation_rad() const { return det_atan2(m_im, m_re); }
};

[[nodiscard]] inline CentredSimilarity centred_similarity(double scale, double rotation_rad, double d_x, double d_y) {
  return {scale * det_cos(rotation_rad), scale * det_sin(rotation_rad), d_x, d_y};
}

/// The same mapping in pixel coordinates of images of `width` x `height`.
[[nodiscard]] inline Similarity2 about_origin(const CentredSimilarity& centred, std::int32_t width,
                                              std::int32_t height) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  double moved_x = 0, moved_y = 0;
  centred.apply(-cx, -cy, moved_x, moved_y);
  return {centred.scale(), centred.rotation_rad(), moved_x + cx, moved_y + cy};
}

}  // namespace ilp
