// A rolling shutter exposes an image's rows one after the other while the camera moves. Its images are brought to the
// time of their middle row, so that everything that follows sees a camera with one pose per image.
//
// Model: row v is exposed at t = readout_s (v / (height - 1) - 1/2) after the middle row. Over a plane, an image is a
// homography of the one at the middle row, to first order I + t M in normalised coordinates (X/Z, Y/Z, 1), with turn
// and velocity of the camera constant while it reads. M is measured (fsw/shared/keyframe_motion.hpp); nothing of it is
// an unknown of an adjustment.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/geometry.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

/// M, row by row without its last element, which is 0. Unit 1/s: a point (x, y) moves with
///   x' = m0 x + m1 y + m2 - x (m6 x + m7 y),   y' = m3 x + m4 y + m5 - y (m6 x + m7 y).
struct ImageMotion {
  double m[8] = {};
};

/// From the middle row, a share of the image's height: -1/2 to 1/2.
[[nodiscard]] double row_share(const CameraModel& camera, double row);
/// Seconds from the middle row's exposure to that of the row.
[[nodiscard]] double row_time_s(const CameraModel& camera, double row);
/// How fast the point moves, 1/s.
[[nodiscard]] Vec2 rate_at(const ImageMotion& motion, const Vec2& normalised);
/// Normalised coordinates at the time `seconds` of what is at `middle` at the time of the middle row, and back.
[[nodiscard]] Vec2 moved(const ImageMotion& motion, double seconds, const Vec2& middle);
[[nodiscard]] Vec2 moved_back(const ImageMotion& motion, double seconds, const Vec2& seen);
/// Where the image has what a global shutter at the time of the middle row would have at `middle`; real px.
[[nodiscard]] Vec2 seen_pixel(const CameraModel& camera, const ImageMotion& motion, const Vec2& middle);

/// Whether no point moves by more than limits::max_rolling_rows until the middle row's time.
[[nodiscard]] bool within_reach(const CameraModel& camera, const ImageMotion& motion);

/// Resamples an image in place to the time of its middle row (Catmull-Rom). Shifts are computed at every sixteenth
/// pixel of every sixteenth row and are bilinear between. Beyond the border the image goes on with its border's grey.
/// False where the motion is not within_reach(): the image is unchanged then. `invalid_argument` for an image whose
/// size is not the camera's. `storage` begins with the image and has limits::max_rolling_rows more rows.
Result<bool> to_middle_row(const CameraModel& camera, const ImageMotion& motion, std::int32_t width,
                           std::int32_t height, std::span<std::uint8_t> storage);

}  // namespace ilp
