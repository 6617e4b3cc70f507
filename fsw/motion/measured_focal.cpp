#include "fsw/motion/measured_focal.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/shared/camera_on_record.hpp"
#include "fsw/vision/calibration/calibration_views.hpp"
#include "fsw/vision/calibration/self_calibration.hpp"

namespace ilp {
namespace {

// Relative: the first freezes the camera, the second may replace a nominal one. Where the error of places nears the
// length of the track, the sigma itself is wrong.
constexpr double max_measured_sigma = 0.01, max_useful_sigma = 0.05;
// Errors of places change slowly: one value in this time is independent of its neighbours (twice the half minute over
// which errors of satellite navigation are alike).
constexpr double place_independence_s = 60;

bool is_within(const PlaneFocal& measured, double relative_sigma) {
  return measured.found && measured.sigma <= relative_sigma * measured.focal;
}

PlaneView plane_view(const KeyframeRecord& keyframe, const NavigationRecord& navigation, const PlanePair& plane,
                     Body body, MeasuredFocal& state) {
  PlaneView view;
  view.pair = plane;
  std::copy_n(navigation.q_cam_from_level, 4, view.q_cam_from_level);
  view.tilt_sigma_rad = navigation.tilt_sigma_rad;
  view.heading_sigma_rad = navigation.heading_sigma_rad;
  view.height_m = navigation.height_m;
  view.height_sigma_m = navigation.height_sigma_m;
  if (!(navigation.horizontal_sigma_m > 0) || body == Body::none) return view;
  const BodyPlace place{navigation.longitude_deg, navigation.latitude_deg, navigation.elevation_m};
  if (!state.placed) state.origin = place;
  state.placed = true;
  offset_from(body, state.origin, place, view.place_m);
  const double since_s = 1e-9 * static_cast<double>(keyframe.time_ns - state.latest_ns);
  const double interval_s = state.latest_ns == 0 ? 1 : std::fmax(since_s, 0.1);
  const double alike = place_independence_s / interval_s;
  view.horizontal_sigma_m = navigation.horizontal_sigma_m * std::sqrt(std::fmax(1, alike));
  state.latest_ns = keyframe.time_ns;
  return view;
}

}  // namespace

void add_keyframe(const KeyframeRecord& keyframe, const NavigationRecord& navigation, const PlanePair& plane,
                  const CameraModel& nominal, Body body, MeasuredFocal& state) {
  PlaneViews& planes = state.planes;
  if (planes.full()) {
    for (std::size_t i = 1; i < planes.size(); ++i) planes[i - 1] = planes[i];
    planes.pop_back();
  }
  static_cast<void>(planes.push_back(plane_view(keyframe, navigation, plane, body, state)));
  const CalibrationParams params;
  const CentredFrame frame(nominal);
  PlaneFocalParams bounds;
  bounds.sigma_centre = params.sigma_centre * nominal.width / frame.unit_x_px;
  bounds.least_noise = params.least_noise_px / frame.unit_x_px;
  state.before = state.newest;
  state.newest = find_plane_focal({planes.data(), planes.size()}, nominal.fx / frame.unit_x_px, bounds);
}

bool suffices(const MeasuredFocal& state) {
  // A small sigma may be chance: the one before has to be nearly as small.
  return is_within(state.newest, max_measured_sigma) && is_within(state.before, 2 * max_measured_sigma);
}

bool is_better_than(double nominal_relative_sigma, const MeasuredFocal& state) {
  return is_within(state.newest, std::fmin(nominal_relative_sigma, max_useful_sigma));
}

CameraRecord measured_camera(const CameraModel& nominal, const MeasuredFocal& state) {
  MetricViews views;
  views.focal = state.newest.focal;
  CameraRecord camera = camera_record(calibrated_camera(nominal, views));
  camera.source = CameraSource::measured;
  camera.sigma_focal_px = state.newest.sigma * CentredFrame(nominal).unit_x_px;
  camera.sigma_cx_px = camera.sigma_cy_px = CalibrationParams{}.sigma_centre * camera.width;
  return camera;
}

}  // namespace ilp
