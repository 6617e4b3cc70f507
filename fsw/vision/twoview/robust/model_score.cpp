#include "fsw/vision/twoview/robust/model_score.hpp"

#include <algorithm>

#include "fsw/vision/twoview/solvers/decompose_essential.hpp"

namespace ilp {
namespace {

/// 1 / (pixels per unit)^2: turns gradients by normalised coordinates into gradients by pixels.
struct InverseSquares {
  explicit InverseSquares(const PixelScale& scale)
      : ax(static_cast<float>(1 / (scale.ax * scale.ax))),
        ay(static_cast<float>(1 / (scale.ay * scale.ay))),
        bx(static_cast<float>(1 / (scale.bx * scale.bx))),
        by(static_cast<float>(1 / (scale.by * scale.by))) {}
  float ax, ay, bx, by;
};

struct FloatMatrix {
  explicit FloatMatrix(const Mat3& m) {
    for (int i = 0; i < 9; ++i) e[i] = static_cast<float>(m(i / 3, i % 3));
  }
  float e[9];
};

void sampson_block(const NormalisedPairs& pairs, std::size_t first, std::size_t count, const FloatMatrix& m,
                   const InverseSquares& w, float* squared) {
  const float* xa = pairs.xa + first;
  const float* ya = pairs.ya + first;
  const float* xb = pairs.xb + first;
  const float* yb = pairs.yb + first;
  const float m0 = m.e[0], m1 = m.e[1], m2 = m.e[2], m3 = m.e[3], m4 = m.e[4], m5 = m.e[5], m6 = m.e[6], m7 = m.e[7],
              m8 = m.e[8];
  for (std::size_t i = 0; i < count; ++i) {
    const float line_b0 = m0 * xa[i] + m1 * ya[i] + m2;
    const float line_b1 = m3 * xa[i] + m4 * ya[i] + m5;
    const float line_b2 = m6 * xa[i] + m7 * ya[i] + m8;
    const float line_a0 = m0 * xb[i] + m3 * yb[i] + m6;
    const float line_a1 = m1 * xb[i] + m4 * yb[i] + m7;
    const float error = xb[i] * line_b0 + yb[i] * line_b1 + line_b2;
    const float gradient2 =
        w.bx * line_b0 * line_b0 + w.by * line_b1 * line_b1 + w.ax * line_a0 * line_a0 + w.ay * line_a1 * line_a1;
    squared[i] = error * error / gradient2;
  }
}

/// Sets `squared` to `outlier` where the rays do not meet in front of both cameras.
void cheirality_block(const NormalisedPairs& pairs, std::size_t first, std::size_t count, const FloatMatrix& rotation,
                      const Vec3& translation, float min_sine2, float outlier, float* squared) {
  const float* xa = pairs.xa + first;
  const float* ya = pairs.ya + first;
  const float* xb = pairs.xb + first;
  const float* yb = pairs.yb + first;
  const float* r = rotation.e;
  const float tx = static_cast<float>(translation.x());
  const float ty = static_cast<float>(translation.y());
  const float tz = static_cast<float>(translation.z());
  for (std::size_t i = 0; i < count; ++i) {
    const float px = r[0] * xa[i] + r[1] * ya[i] + r[2];
    const float py = r[3] * xa[i] + r[4] * ya[i] + r[5];
    const float pz = r[6] * xa[i] + r[7] * ya[i] + r[8];
    const float qx = xb[i];
    const float qy = yb[i];
    const float nx = py - pz * qy;
    const float ny = pz * qx - px;
    const float nz = px * qy - py * qx;
    const float depth_a = (qy * tz - ty) * nx + (tx - qx * tz) * ny + (qx * ty - qy * tx) * nz;
    const float depth_b = (py * tz - pz * ty) * nx + (pz * tx - px * tz) * ny + (px * ty - py * tx) * nz;
    const float sine2 = nx * nx + ny * ny + nz * nz;
    const float lengths = (px * px + py * py + pz * pz) * (qx * qx + qy * qy + 1.0F);
    const float nearer = depth_a < depth_b ? depth_a : depth_b;
    const float cosine = px * qx + py * qy + pz;
    const float deciding = sine2 < min_sine2 * lengths ? cosine : nearer;
    squared[i] = deciding > 0.0F ? squared[i] : outlier;
  }
}

void transfer_block(const NormalisedPairs& pairs, std::size_t first, std::size_t count, const FloatMatrix& homography,
                    float outlier, float* squared) {
  const float* h = homography.e;
  const auto scale_x = static_cast<float>(pairs.scale.bx);
  const auto scale_y = static_cast<float>(pairs.scale.by);
  const float* xa = pairs.xa + first;
  const float* ya = pairs.ya + first;
  const float* xb = pairs.xb + first;
  const float* yb = pairs.yb + first;
  for (std::size_t i = 0; i < count; ++i) {
    const float w = h[6] * xa[i] + h[7] * ya[i] + h[8];
    const float du = ((h[0] * xa[i] + h[1] * ya[i] + h[2]) / w - xb[i]) * scale_x;
    const float dv = ((h[3] * xa[i] + h[4] * ya[i] + h[5]) / w - yb[i]) * scale_y;
    const float distance2 = du * du + dv * dv;
    squared[i] = w > 0.0F ? distance2 : outlier;
  }
}

/// Scores block by block; `errors(first, count, squared)` writes the squared errors of a block. False as soon as
/// `bound` abandons the model.
template <typename Errors>
bool score_blocks(const NormalisedPairs& pairs, double threshold_px, const CostBound& bound, RansacScore& score,
                  const Errors& errors) {
  const auto threshold2 = static_cast<float>(threshold_px * threshold_px);
  const BailOut abandoned(bound, threshold_px * threshold_px, pairs.size());
  score = {};
  float squared[score_block];
  for (std::size_t first = 0; first < pairs.size(); first += score_block) {
    const std::size_t count = std::min(score_block, pairs.size() - first);
    errors(first, count, squared);
    add_block(squared, count, threshold2, score);
    if (abandoned(score.cost, first + count)) return false;
  }
  return true;
}

}  // namespace

double threshold_angle(const PixelScale& scale, double threshold_px) {
  return threshold_px * 2 / (scale.bx + scale.by);
}

bool score_epipolar(const NormalisedPairs& pairs, const Mat3& m, double threshold_px, const CostBound& bound,
                    RansacScore& score) {
  const FloatMatrix matrix(m);
  const InverseSquares weights(pairs.scale);
  return score_blocks(pairs, threshold_px, bound, score, [&](std::size_t first, std::size_t count, float* squared) {
    sampson_block(pairs, first, count, matrix, weights, squared);
  });
}

bool score_pose(const NormalisedPairs& pairs, const RigidTransform& b_from_a, double threshold_px,
                const CostBound& bound, RansacScore& score) {
  const FloatMatrix matrix(essential_from_pose(b_from_a));
  const FloatMatrix rotation(b_from_a.rotation);
  const InverseSquares weights(pairs.scale);
  const auto outlier = static_cast<float>(threshold_px * threshold_px);
  const double min_angle = threshold_angle(pairs.scale, threshold_px);
  const auto min_sine2 = static_cast<float>(min_angle * min_angle);
  return score_blocks(pairs, threshold_px, bound, score, [&](std::size_t first, std::size_t count, float* squared) {
    sampson_block(pairs, first, count, matrix, weights, squared);
    cheirality_block(pairs, first, count, rotation, b_from_a.translation, min_sine2, outlier, squared);
  });
}

bool score_homography(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px, const CostBound& bound,
                      RansacScore& score) {
  const FloatMatrix matrix(homography);
  const auto outlier = static_cast<float>(threshold_px * threshold_px);
  return score_blocks(pairs, threshold_px, bound, score, [&](std::size_t first, std::size_t count, float* squared) {
    transfer_block(pairs, first, count, matrix, outlier, squared);
  });
}

}  // namespace ilp
