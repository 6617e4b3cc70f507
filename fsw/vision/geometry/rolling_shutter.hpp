// Corrects images of a rolling shutter, which exposes rows one after the other while the camera moves: they are
// resampled to the time of the middle row, so that the kernels can assume one pose per image.
//
// Model: row v is exposed at t = readout_s (v / (height - 1) - 1/2) after the middle row. Over a plane, a homography
// maps the image at the middle row's time to the image at t. To first order it is I + t M in normalised coordinates
// (X/Z, Y/Z, 1), if the camera's angular and linear velocity are constant during the readout. M is measured
// (fsw/shared/keyframe_motion.hpp) and is no unknown of an adjustment.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/geometry.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

/// M, row by row without its last element, which is 0. Unit: 1/s. A point (x, y) has the velocity
///   x' = m0 x + m1 y + m2 - x (m6 x + m7 y),   y' = m3 x + m4 y + m5 - y (m6 x + m7 y).
struct ImageMotion {
  double m[8] = {};
};

/// Distance of a row from the middle row, as a share of the image's height: -1/2 to 1/2.
[[nodiscard]] double row_share(const CameraModel& camera, double row);
/// Seconds from the exposure of the middle row to that of the row.
[[nodiscard]] double row_time_s(const CameraModel& camera, double row);
/// Velocity of a point, normalised coordinates per second.
[[nodiscard]] Vec2 rate_at(const ImageMotion& motion, const Vec2& normalised);
/// moved(): normalised coordinates at the time `seconds` of the point that is at `middle` at the middle row's time.
/// moved_back() is its inverse.
[[nodiscard]] Vec2 moved(const ImageMotion& motion, double seconds, const Vec2& middle);
[[nodiscard]] Vec2 moved_back(const ImageMotion& motion, double seconds, const Vec2& seen);
/// The pixel at which the image shows the point that a global shutter at the middle row's time would show at pixel
/// `middle`. Both are real (distorted) px.
[[nodiscard]] Vec2 seen_pixel(const CameraModel& camera, const ImageMotion& motion, const Vec2& middle);

/// True if to_middle_row() can correct the motion: from its exposure to the middle row's time, no point moves by more
/// than limits::max_rolling_rows - 4 rows, or by the image's width.
[[nodiscard]] bool within_reach(const CameraModel& camera, const ImageMotion& motion);

/// Resamples an image in place to the time of its middle row (Catmull-Rom). Shifts are computed at every sixteenth
/// pixel of every sixteenth row and interpolated bilinearly. Beyond the border, pixels have the grey of the border.
/// `storage` begins with the image and has limits::max_rolling_rows more rows. Returns false, with the image unchanged,
/// if the motion is not within_reach(); `invalid_argument` if the size is not that of the camera or `storage` is too
/// small.
Result<bool> to_middle_row(const CameraModel& camera, const ImageMotion& motion, std::int32_t width,
                           std::int32_t height, std::span<std::uint8_t> storage);

}  // namespace ilp
