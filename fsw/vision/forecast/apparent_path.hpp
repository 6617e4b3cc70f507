// The path of the image's centre over the ground, from measured overlaps.
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Position of the image's centre on the ground at one time, and rotation and scale of the image. With complex numbers,
/// in pixels from the image's centre: z_frame = m (z_first - p), where z_first is a point of the path's first image.
struct PathPoint {
  TimeNs time_ns = 0;
  double p_x = 0, p_y = 0;        ///< px of the first image
  double m_re = 1, m_im = 0;      ///< scale * exp(i rotation), relative to the first image
  double tilt_x = 0, tilt_y = 0;  ///< direction of the optical axis, px of the first image from its centre
  bool time_trusted = true;       ///< false: the point is not used for speeds
  bool tilt_known = false;
};

/// The last points of a strip's path. Trivially copyable, so that it can be part of a checkpoint.
struct ApparentPath {
  FixedVector<PathPoint, 24> points;  ///< in order of time
  PathPoint keyframe;                 ///< the latest keyframe
};

/// Begins a path at a keyframe.
void begin_path(TimeNs keyframe_ns, ApparentPath& path);
/// Adds a frame exposed after all others; `frame_from_keyframe` is in full-resolution pixels. Returns false, without
/// adding it, if the time does not increase or the scale is not positive. A full path drops its oldest point. The time
/// of the first point always counts as trusted.
[[nodiscard]] bool extend_path(std::int32_t width, std::int32_t height, TimeNs frame_ns,
                               const Similarity2& frame_from_keyframe, bool time_trusted, ApparentPath& path);
/// Makes the point of this time the keyframe. Returns false, without a change, if there is no such point.
[[nodiscard]] bool select_place(TimeNs keyframe_ns, ApparentPath& path);

/// Stores the direction of the optical axis at the point of this time. Returns false if there is no such point.
bool set_tilt(TimeNs frame_ns, double tilt_x_px, double tilt_y_px, ApparentPath& path);

/// Overlap (0 to 1) of the keyframe with a frame at p = (p_x, p_y) and m = (m_re, m_im), as in PathPoint.
[[nodiscard]] double overlap_of_places(std::int32_t width, std::int32_t height, const PathPoint& keyframe, double p_x,
                                       double p_y, double m_re, double m_im);

}  // namespace ilp
