// The way of the image's centre over the ground, put together from measured overlaps.
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Where the image's centre met the ground at one time, and how the image lay there. With complex numbers, in pixels
/// from the image's centre: z_frame = m (z_first - p), where z_first is a place in the image that began the path.
struct PathPoint {
  TimeNs time_ns = 0;
  double p_x = 0, p_y = 0;        ///< px of the first image
  double m_re = 1, m_im = 0;      ///< scale * exp(i rotation) against the first image
  double tilt_x = 0, tilt_y = 0;  ///< where the optical axis points, px of the first image from its centre
  bool time_trusted = true;       ///< otherwise no speed is taken from it
  bool tilt_known = false;
};

/// The last places of a strip; trivially copyable, so that it can be a checkpoint.
struct ApparentPath {
  FixedVector<PathPoint, 24> points;  ///< in order of time
  PathPoint keyframe;                 ///< the latest one
};

/// A path begins at a keyframe of its own.
void begin_path(TimeNs keyframe_ns, ApparentPath& path);
/// A frame taken after all others; `frame_from_keyframe` in full-resolution pixels. False, and nothing added, when the
/// time does not increase or the scale is not positive. The oldest place makes room for the newest; the first one is
/// trusted always.
[[nodiscard]] bool extend_path(std::int32_t width, std::int32_t height, TimeNs frame_ns,
                               const Similarity2& frame_from_keyframe, bool time_trusted, ApparentPath& path);
/// The place of this time becomes the keyframe. False, and nothing changed, when the path does not have it.
[[nodiscard]] bool select_place(TimeNs keyframe_ns, ApparentPath& path);

/// The camera's direction at the place of this time became known. False when the path does not have it.
bool set_tilt(TimeNs frame_ns, double tilt_x_px, double tilt_y_px, ApparentPath& path);

/// Overlap of the keyframe with a frame whose centre is at (p_x, p_y) and which lies as (m_re, m_im) says.
[[nodiscard]] double overlap_of_places(std::int32_t width, std::int32_t height, const PathPoint& keyframe, double p_x,
                                       double p_y, double m_re, double m_im);

}  // namespace ilp
