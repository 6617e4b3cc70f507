// When the overlap with the last keyframe will have fallen to its target: the apparent motion of the ground,
// extrapolated from the overlaps measured so far (paper 3.1, "time of the next capture"; decisions.md, 3).
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Where the image's centre met the ground at one time, and how the image lay there. With complex numbers, in pixels
/// from the image's centre: z_frame = m (z_first - p), where z_first is a place in the image that began the path.
struct PathPoint {
  TimeNs time_ns = 0;
  double p_x = 0, p_y = 0;    ///< px of the first image
  double m_re = 1, m_im = 0;  ///< scale * exp(i rotation) against the first image
  bool time_trusted = true;   ///< otherwise no speed is taken from it
};

/// The last places of a strip; trivially copyable, so that it can be a checkpoint.
struct ApparentPath {
  FixedVector<PathPoint, 12> points;  ///< in order of time
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

struct ForecastParams {
  double target_overlap = 0.82;
  /// Weight of an interval against the next younger one. A gust lasts about as long as the way between two keyframes:
  /// older intervals tell the mean wind, the youngest the gust.
  double memory = 0.6;
  /// The speed's trend counts so much: a gust that grows does not grow on for the whole way.
  double trend = 0.15;
  /// Of the speed, when too few intervals are known to see it scatter.
  double unknown_speed_error = 0.3;
  double least_speed_error = 0.05;  ///< share of the speed; no wind is steadier
};

struct Forecast {
  bool known = false;     ///< two trusted places at least; otherwise the rest says nothing
  bool reached = false;   ///< the overlap falls to its target within the longest interval
  TimeNs time_ns = 0;     ///< of the target, or the end of the longest interval
  double overlap = 1;     ///< at that time
  double sigma = 0;       ///< one-sigma error of the overlap at that time
  double speed_px_s = 0;  ///< of the ground's centre, in pixels of the keyframe
};

/// The overlap of the keyframe with a frame taken at `time_ns`. The velocity is a weighted line through the velocities
/// of the intervals, robust against a single wrong one (a mis-stamped frame).
[[nodiscard]] Forecast forecast_overlap(std::int32_t width, std::int32_t height, const ApparentPath& path,
                                        const ForecastParams& params, TimeNs time_ns);
/// The first time in [earliest, latest] at which the overlap is at or below the target.
[[nodiscard]] Forecast forecast_capture(std::int32_t width, std::int32_t height, const ApparentPath& path,
                                        const ForecastParams& params, TimeNs earliest_ns, TimeNs latest_ns);

}  // namespace ilp
