// The path of the image's centre over the ground, made of measured overlaps.
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// The place of the image's centre on the ground at one time, and the turn and scale of the image there. With complex
/// numbers, in pixels from the image's centre: z_frame = m (z_first - p); z_first is a place in the path's first image.
struct PathPoint {
  TimeNs time_ns = 0;
  double p_x = 0, p_y = 0;        ///< px of the first image
  double m_re = 1, m_im = 0;      ///< scale * exp(i rotation) against the first image
  double tilt_x = 0, tilt_y = 0;  ///< where the optical axis points, px of the first image from its centre
  bool time_trusted = true;       ///< no speed is taken from a time that is not trusted
  bool tilt_known = false;
};

/// The last places of a strip. Trivially copyable, so that it can be a checkpoint.
struct ApparentPath {
  FixedVector<PathPoint, 24> points;  ///< in order of time
  PathPoint keyframe;                 ///< the latest keyframe
};

/// Begins a path at a keyframe.
void begin_path(TimeNs keyframe_ns, ApparentPath& path);
/// Adds a frame taken after all others; `frame_from_keyframe` in full-resolution pixels. False, and nothing is added,
/// when the time does not increase or the scale is not positive. The oldest place makes room for the newest. The first
/// place always counts as trusted.
[[nodiscard]] bool extend_path(std::int32_t width, std::int32_t height, TimeNs frame_ns,
                               const Similarity2& frame_from_keyframe, bool time_trusted, ApparentPath& path);
/// Makes the place of this time the keyframe. False, and nothing changes, when the path has no such place.
[[nodiscard]] bool select_place(TimeNs keyframe_ns, ApparentPath& path);

/// Records the camera's direction at the place of this time. False when the path has no such place.
bool set_tilt(TimeNs frame_ns, double tilt_x_px, double tilt_y_px, ApparentPath& path);

/// Overlap of the keyframe with a frame whose centre is at (p_x, p_y), turned and scaled by (m_re, m_im).
[[nodiscard]] double overlap_of_places(std::int32_t width, std::int32_t height, const PathPoint& keyframe, double p_x,
                                       double p_y, double m_re, double m_im);

}  // namespace ilp
