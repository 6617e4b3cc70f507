// Which ground an image sees that another one sees too: from true poses and true depths alone, whatever the ground is.
// One pose holds for a whole image: what a rolling shutter does to it is not followed.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::world {

/// Truth of an image on a grid of samples: the middles of blocks of stride x stride pixels (the last ones may be cut).
struct TrueFrame {
  CameraModel camera;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  std::int32_t stride = 1;  ///< px, odd
  std::int32_t columns = 0, rows = 0;
  std::vector<float> depth;  ///< z of the ground in the camera, row by row; not positive and finite: none
  std::vector<Vec3> ground;  ///< the point in the world; not finite where there is no depth
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< box around all ground that the image shows

  [[nodiscard]] std::size_t index(std::int32_t column, std::int32_t row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }
};

/// `depth` has a value for each pixel of the image as taken (distortion included). std::invalid_argument when it has
/// not the camera's size or the stride is not odd and positive.
[[nodiscard]] TrueFrame true_frame(const CameraModel& camera, const Mat3& cam_from_world, const Vec3& centre,
                                   ImageView<const float> depth, std::int32_t stride);

/// The stride with about 128 samples in a row.
[[nodiscard]] std::int32_t sample_stride(const CameraModel& camera);

/// Where a point of the world appears in a frame; false behind the camera or outside [-0.5, size - 0.5].
[[nodiscard]] bool project(const TrueFrame& frame, const Vec3& point, Vec2& pixel, double& depth);

/// The point is inside the image and no ground stands in front of it. A point is hidden when it lies deeper than all
/// four depth samples around it by more than 1 %: what is smaller than a block hides nothing.
[[nodiscard]] bool sees(const TrueFrame& frame, const Vec3& point);

/// Share of a's area whose ground b sees too (decisions.md, 2), in [0, 1]; ground that b cannot see for something in
/// front of it does not count. Blocks on the border of b count by the share inside: for level ground and a shift along
/// the image's axes exact, within 0.002 under 20 degrees of turn and 5 degrees of tilt at 128 samples in a row. Pixels
/// without depth belong to a's area and are not seen again.
[[nodiscard]] double true_overlap(const TrueFrame& a, const TrueFrame& b);
/// The same without occlusion: comparable with the onboard number, which is the overlap of footprints
/// (fsw/vision/overlap/overlap.hpp).
[[nodiscard]] double true_footprint_overlap(const TrueFrame& a, const TrueFrame& b);

/// Keyframe and the one that it is matched with.
struct FramePair {
  const TrueFrame* first = nullptr;
  const TrueFrame* second = nullptr;
};

/// 255 where any of the earlier frames sees the ground of a sample, else 0; one pixel per sample of `frame`.
[[nodiscard]] host::Raster<std::uint8_t> visible_before_mask(const TrueFrame& frame,
                                                             std::span<const TrueFrame* const> earlier);
/// The correct onboard mask of a keyframe (decisions.md, 9): 255 where its pair sees the ground and no earlier pair
/// has seen it with both images and as well. Without a partner (null) everything counts as seen by the pair. An earlier
/// pair has seen ground as well unless it lay farther from the pair's first image by more than the factor `finer`.
[[nodiscard]] host::Raster<std::uint8_t> newly_seen_mask(const TrueFrame& frame, const TrueFrame* partner,
                                                         std::span<const FramePair> earlier_pairs,
                                                         double finer = std::numeric_limits<double>::infinity());

}  // namespace ilp::world
