// A few views of common points, the input of self-calibration.
//
// Image coordinates are *centred*: (ideal px - principal point as far as known) / ((width + height) / 2), so that they
// and the focal length are near one. A point is X = (x, y, 1, w) in the frame of the first view: (x, y) is its image
// there, and w is its distance from the plane w = 0 (projective) or its inverse depth (metric). A camera is P = [M |
// m], q = P X, u = q_0 / q_2, v = q_1 / q_2.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {

/// One point through consecutive views. Bit v of the masks is view v.
struct CalibrationTrack {
  std::array<double, limits::max_calibration_views> u{}, v{};  ///< centred
  double point[3] = {0, 0, 0};                                 ///< x, y, w
  std::uint16_t corner = 0;                                    ///< of the newest view that sees it
  std::uint8_t seen = 0;                                       ///< bit v: view v has an observation
  std::uint8_t used = 0;  ///< a part of `seen`: observations that agree with the rest
  bool known = false;     ///< `point` is valid
};
using CalibrationTracks = FixedVector<CalibrationTrack, limits::max_calibration_tracks>;

using ViewSet = std::uint8_t;
[[nodiscard]] constexpr bool has_view(ViewSet set, std::size_t view) {
  return ((set >> view) & 1U) != 0;
}
[[nodiscard]] constexpr ViewSet only_view(std::size_t view) {
  return static_cast<ViewSet>(1U << view);
}
[[nodiscard]] constexpr std::uint32_t view_count(ViewSet set) {
  return static_cast<std::uint32_t>(std::popcount(set));
}

/// 3x4, row-major.
struct ProjectiveCamera {
  double p[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
};
using ProjectiveCameras = std::array<ProjectiveCamera, limits::max_calibration_views>;

/// y = R (x, y, 1) + w t in the camera.
struct MetricCamera {
  double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major
  double translation[3] = {0, 0, 0};
};

/// Views of one camera: square pixels, no skew; u = focal y_0 / y_2 + cx.
struct MetricViews {
  std::array<MetricCamera, limits::max_calibration_views> cameras;
  double focal = 1;  ///< centred units
  double cx = 0, cy = 0;
};
static_assert(std::is_trivially_copyable_v<CalibrationTracks> && std::is_trivially_copyable_v<MetricViews>);

/// Converts ideal pixels to centred coordinates and back. The middle is the nominal principal point, and pixels have
/// the nominal aspect. The nominal focal length is not used.
struct CentredFrame {
  double middle_x_px = 0, middle_y_px = 0;
  double unit_x_px = 1, unit_y_px = 1;

  constexpr CentredFrame() = default;
  explicit constexpr CentredFrame(const CameraModel& nominal)
      : middle_x_px(nominal.cx),
        middle_y_px(nominal.cy),
        unit_x_px(0.5 * (nominal.width + nominal.height)),
        unit_y_px(unit_x_px * nominal.fy / nominal.fx) {}
  [[nodiscard]] constexpr double u(double x_px) const { return (x_px - middle_x_px) / unit_x_px; }
  [[nodiscard]] constexpr double v(double y_px) const { return (y_px - middle_y_px) / unit_y_px; }
  [[nodiscard]] constexpr double x_px(double u) const { return u * unit_x_px + middle_x_px; }
  [[nodiscard]] constexpr double y_px(double v) const { return v * unit_y_px + middle_y_px; }
};

/// The nominal camera with the focal length and the principal point of `views`. The distortion is converted to the new
/// unit. It bends the same pixels, except that its centre moves with the principal point: if that is many pixels and
/// the distortion strong, calibrate again with this camera as the nominal one.
[[nodiscard]] inline CameraModel calibrated_camera(const CameraModel& nominal, const MetricViews& views) {
  const CentredFrame frame(nominal);
  CameraModel out = with_focal_length(nominal, views.focal * frame.unit_x_px / nominal.fx);
  out.fx = views.focal * frame.unit_x_px;
  out.fy = views.focal * frame.unit_y_px;
  out.cx = frame.x_px(views.cx);
  out.cy = frame.y_px(views.cy);
  return out;
}

}  // namespace ilp
