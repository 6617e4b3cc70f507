// Computes which ground of an image other images see too, from true poses and depths only. Each image has one pose: the
// effect of a rolling shutter is ignored.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::world {

/// Truth of an image on a grid of samples, one in the middle of each block of stride x stride pixels. The last blocks
/// of rows and columns may be smaller.
struct TrueFrame {
  CameraModel camera;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  std::int32_t stride = 1;  ///< px, odd
  std::int32_t columns = 0, rows = 0;
  std::vector<float> depth;  ///< z of the ground in the camera, row by row; none unless positive and finite
  std::vector<Vec3> ground;  ///< the ground point in the world, row by row; NaN without depth
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< box around all ground in the image, with a margin

  [[nodiscard]] std::size_t index(std::int32_t column, std::int32_t row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }
};

/// Makes the truth of an image. `depth` has a value for each pixel of the image as taken (distortion included). Throws
/// std::invalid_argument if it does not have the camera's size, or if the stride is not odd and positive.
[[nodiscard]] TrueFrame true_frame(const CameraModel& camera, const Mat3& cam_from_world, const Vec3& centre,
                                   ImageView<const float> depth, std::int32_t stride);

/// The stride with about 128 samples in a row.
[[nodiscard]] std::int32_t sample_stride(const CameraModel& camera);

/// Projects a point of the world into a frame. Returns false for a point behind the camera or outside the image, [-0.5,
/// size - 0.5].
[[nodiscard]] bool project(const TrueFrame& frame, const Vec3& point, Vec2& pixel, double& depth);

/// Whether the point is inside the image and not hidden by other ground. A point is hidden if it is deeper than each of
/// the four depth samples around its pixel by more than 1 %. Ground smaller than a block therefore hides nothing.
[[nodiscard]] bool sees(const TrueFrame& frame, const Vec3& point);

/// Share of a's area whose ground b sees too (decisions.md, 2), in [0, 1]. Ground that is hidden in b does not count.
/// Blocks on the border of b count with their share inside b. The result is exact for level ground and a shift along
/// the image's axes; its error is below 0.002 for 20 degrees of rotation and 5 degrees of tilt at 128 samples in a row.
/// Pixels without depth belong to a's area and count as not seen by b.
[[nodiscard]] double true_overlap(const TrueFrame& a, const TrueFrame& b);
/// The same without occlusion, for comparison with the overlap of footprints that the flight measures
/// (fsw/vision/overlap/overlap.hpp).
[[nodiscard]] double true_footprint_overlap(const TrueFrame& a, const TrueFrame& b);

/// A keyframe and its stereo partner.
struct FramePair {
  const TrueFrame* first = nullptr;
  const TrueFrame* second = nullptr;
};

/// A mask with one pixel per sample of `frame`: 255 if any of the earlier frames sees the sample's ground, else 0.
[[nodiscard]] host::Raster<std::uint8_t> visible_before_mask(const TrueFrame& frame,
                                                             std::span<const TrueFrame* const> earlier);
/// The correct onboard mask of a keyframe (decisions.md, 9), one pixel per sample: 255 if the partner sees the sample's
/// ground too, and no earlier pair has seen the ground with both images and equally well; else 0. Without a partner
/// (null) the first condition is dropped. An earlier pair has seen ground equally well if its depth in the pair's first
/// image is at most `finer` times the depth in `frame`.
[[nodiscard]] host::Raster<std::uint8_t> newly_seen_mask(const TrueFrame& frame, const TrueFrame* partner,
                                                         std::span<const FramePair> earlier_pairs,
                                                         double finer = std::numeric_limits<double>::infinity());

}  // namespace ilp::world
