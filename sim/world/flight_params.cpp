#include "sim/world/flight_params.hpp"

#include <cmath>
#include <stdexcept>

#include "cfg/limits.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/status_error.hpp"
#include "sim/world/ground_track.hpp"
#include "sim/world/passes.hpp"

namespace ilp::world {
namespace {

[[noreturn]] void refuse(const char* section, const char* name, const std::string& value, const std::string& expected) {
  throw std::invalid_argument(std::string("[") + section + "] " + name + " = " + value + ": expected " + expected);
}

/// The altitude at which a descent ends.
double final_altitude(const FlightParams& p) {
  if (p.descent_ratio > 0) return p.altitude_m / p.descent_ratio;
  return p.altitude_m - p.descent_m_s * flight_length_s(p) * det_cos(p.off_nadir_rad);
}

bool takes_a_frame(const FlightParams& p) {
  const double last = flight_length_s(p);
  return p.gap_length_s <= 0 || p.gap_start_s > 0 || p.gap_start_s + p.gap_length_s <= last;
}

void validate_camera(const CameraModel& camera) {
  CameraModel copy = camera;
  check_parameters(parameters(copy), "camera");
  const Status status = ilp::validate(camera);
  if (!status.ok()) throw std::invalid_argument("[camera]: " + host::status_sentence(status));
}

}  // namespace

CameraModel default_camera() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 550;
  camera.fy = 550;
  camera.cx = camera.cy = -1;
  return centred(camera);
}

CameraModel centred(CameraModel camera) {
  if (!(camera.cx >= 0)) camera.cx = 0.5 * (camera.width - 1);
  if (!(camera.cy >= 0)) camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

std::vector<Parameter> parameters(FlightParams& p) {
  constexpr double turn = 2 * pi;
  return {
      {"seed", &p.seed, "", "seed of wind, swing and sensor noise"},
      {"kind", &p.kind, "", "kind of flight: balloon, line, hover or descent"},
      {"frames", &p.frames, "", "number of instants at which the camera may take a frame", 1, 9999},
      {"interval_s", &p.interval_s, "s", "interval between frames", 1e-3, 1e4},
      {"altitude_m", &p.altitude_m, "m", "altitude of the camera at rest, above the ground's level 0", 1e-3, 1e6},
      {"altitude_oscillation", &p.altitude_oscillation, "",
       "amplitude of the altitude's oscillation, as a share of the altitude", 0, 0.5},
      {"altitude_period_s", &p.altitude_period_s, "s", "period of the altitude's oscillation", 1e-3, 1e6},
      {"drift_m_s", &p.drift_m_s, "m/s", "mean speed over the ground", 0, 1e3},
      {"drift_heading_rad", &p.drift_heading_rad, "rad", "direction of the drift, from x towards y", -turn, turn},
      {"meander_m", &p.meander_m, "m", "amplitude of the track across the drift", 0, 1e5},
      {"meander_period_s", &p.meander_period_s, "s", "period of the meander", 1e-3, 1e6},
      {"gust_m_s", &p.gust_m_s, "m/s", "standard deviation of the wind's speed on each axis", 0, 100},
      {"gust_time_s", &p.gust_time_s, "s", "correlation time of gusts", 0.1, 1e6},
      {"balloon_lag_s", &p.balloon_lag_s, "s", "time constant of the balloon in a gust", 0.1, 1e4},
      {"suspension_m", &p.suspension_m, "m", "length of the pendulum of balloon and camera", 0.1, 1e4},
      {"gravity_m_s2", &p.gravity_m_s2, "m/s^2",
       "gravity at the ground; with suspension_m it gives the period of the swing", 0.01, 100},
      {"swing_rad", &p.swing_rad, "rad",
       "amplitude of the swing at the beginning, along the drift; across it is half as large", 0, 0.5},
      {"swing_damping", &p.swing_damping, "", "damping of the swing, ratio to critical damping", 0, 1},
      {"yaw_rad", &p.yaw_rad, "rad", "amplitude of the oscillation about the vertical", 0, turn},
      {"yaw_period_s", &p.yaw_period_s, "s", "period of the oscillation about the vertical", 1e-3, 1e6},
      {"yaw_rate_rad_s", &p.yaw_rate_rad_s, "rad/s", "steady rotation about the vertical", -1, 1},
      {"off_nadir_rad", &p.off_nadir_rad, "rad", "angle of the optical axis from straight below", 0, 1.4},
      {"off_nadir_azimuth_rad", &p.off_nadir_azimuth_rad, "rad",
       "azimuth of the optical axis, from the image's x axis at rest", -turn, turn},
      {"descent_m_s", &p.descent_m_s, "m/s", "speed of a descent along the optical axis", 0, 1e3},
      {"descent_ratio", &p.descent_ratio, "",
       "first height of a descent over its last, both above the ground's level 0; the height shrinks by the same "
       "factor "
       "between all frames; 0: constant speed",
       0, 1e4},
      {"descent_drift", &p.descent_drift, "",
       "way across, along drift_heading_rad, for each metre of a descent with a descent_ratio", 0, 10},
      {"gap_start_s", &p.gap_start_s, "s", "time from which no frames are taken", 0, 1e8},
      {"gap_length_s", &p.gap_length_s, "s", "time for which no frames are taken; 0: no gap", 0, 1e8},
      {"pattern", &p.pattern, "",
       "what a balloon or a line flies: straight, lawn-mower, circle, rectangle, figure-eight or rosette"},
      {"pattern_length_m", &p.pattern_length_m, "m",
       "length of a lawn-mower's legs, a rectangle, a figure-eight or a rosette's lines; diameter of a circle", 1e-3,
       1e6},
      {"pattern_width_m", &p.pattern_width_m, "m", "width of a rectangle or a figure-eight", 1e-3, 1e6},
      {"pattern_turn_radius_m", &p.pattern_turn_radius_m, "m",
       "radius of the turns of a lawn-mower, a rectangle or a rosette", 1e-3, 1e6},
      {"side_overlap", &p.side_overlap, "", "overlap of neighbouring legs of a lawn-mower, over level ground", 0, 0.95},
      {"turn_with_track", &p.turn_with_track, "", "the camera turns with the pattern"},
      {"start_x_m", &p.start_x_m, "m", "x of the start", -1e6, 1e6},
      {"start_y_m", &p.start_y_m, "m", "y of the start", -1e6, 1e6},
      {"passes", &p.passes, "", "number of times that the pattern is flown, in equal numbers of frames", 1, 16},
      {"pass_pause_s", &p.pass_pause_s, "s", "time between passes, without frames", 1e-3, 1e6},
      {"pass_altitude", &p.pass_altitude, "", "altitude of a pass over that of the pass before", 0.25, 4},
      {"pass_heading_rad", &p.pass_heading_rad, "rad",
       "angle by which each pass is turned against the one before, about the middle of the pattern", -turn, turn},
      {"pass_yaw_rad", &p.pass_yaw_rad, "rad", "angle by which the camera is turned in addition", -turn, turn},
      {"pass_sun_azimuth_rad", &p.pass_sun_azimuth_rad, "rad",
       "angle by which the sun's azimuth is further in each pass", -turn, turn},
      {"revisit", &p.revisit, "", "share of the flight after which it turns back over old ground; 0: never", 0, 1},
      {"revisit_turn_s", &p.revisit_turn_s, "s", "time that turning back takes", 1e-3, 1e6},
      {"revisit_offset_m", &p.revisit_offset_m, "m", "distance of the way back from the way out, to the left", -1e5,
       1e5},
      {"revisit_yaw_rad", &p.revisit_yaw_rad, "rad", "angle by which the camera is turned on the way back", -turn,
       turn},
      {"altimeter", &p.altimeter, "", "each frame comes with the height above the ground below"},
  };
}

std::vector<Parameter> parameters(CameraModel& c) {
  constexpr double side = limits::min_image_side;
  return {
      {"width", &c.width, "px", "width of the image", side, limits::max_image_width},
      {"height", &c.height, "px", "height of the image", side, limits::max_image_height},
      {"fx", &c.fx, "px", "focal length along x", 1, 1e5},
      {"fy", &c.fy, "px", "focal length along y", 1, 1e5},
      {"cx", &c.cx, "px", "principal point, from the middle of the first pixel; negative: the image's centre", -1, 1e5},
      {"cy", &c.cy, "px", "principal point, from the middle of the first pixel; negative: the image's centre", -1, 1e5},
      {"k1", &c.k1, "", "distortion, radial", -10, 10},
      {"k2", &c.k2, "", "distortion, radial", -10, 10},
      {"p1", &c.p1, "", "distortion, tangential", -1, 1},
      {"p2", &c.p2, "", "distortion, tangential", -1, 1},
      {"k3", &c.k3, "", "distortion, radial", -10, 10},
      {"k4", &c.k4, "", "distortion, radial, below the line; of a fisheye above it", -10, 10},
      {"k5", &c.k5, "", "distortion, radial, below the line", -10, 10},
      {"k6", &c.k6, "", "distortion, radial, below the line", -10, 10},
      {"lens", &c.lens, "", "brown or fisheye: what the numbers mean"},
      {"readout_s", &c.readout_s, "s", "readout that the flight is told; effects.readout_s is what the camera does",
       -0.5, 0.5},
  };
}

double flight_length_s(const FlightParams& p) {
  return time_of_frame_s(p, p.frames - 1);
}

void validate(const FlightParams& flight) {
  FlightParams p = flight;
  check_parameters(parameters(p), "flight");
  if (p.kind != "balloon" && p.kind != "line" && p.kind != "hover" && p.kind != "descent")
    refuse("flight", "kind", p.kind, "balloon, line, hover or descent");
  if (p.revisit > 0 && p.kind != "balloon" && p.kind != "line")
    refuse("flight", "revisit", number_text(p.revisit), "0 for a " + p.kind + ": only a balloon or a line turns back");
  if (p.descent_ratio > 0 && p.descent_ratio < 1)
    refuse("flight", "descent_ratio", number_text(p.descent_ratio), "at least 1, or 0 for a constant speed");
  const bool drifts = p.kind == "balloon" || p.kind == "line";
  if (!is_pattern(p.pattern)) refuse("flight", "pattern", p.pattern, pattern_names());
  if (p.pattern != "straight" && !drifts)
    refuse("flight", "pattern", p.pattern, "straight for a " + p.kind + ": only a balloon or a line flies patterns");
  if (const std::string fault = fault_of_pattern(p); !fault.empty()) throw std::invalid_argument("[flight] " + fault);
  if (p.passes > 1 && p.kind == "descent") refuse("flight", "passes", std::to_string(p.passes), "1 for a descent");
  if (p.revisit > 0 && (p.pattern != "straight" || p.passes > 1))
    refuse("flight", "revisit", number_text(p.revisit), "0 for a pattern or several passes");
  if (p.kind == "descent" && !(final_altitude(p) > 0)) {
    refuse("flight", "descent_m_s", number_text(p.descent_m_s),
           "a descent that ends above the ground: after " + number_text(flight_length_s(p)) + " s its altitude is " +
               number_text(final_altitude(p)) + " m");
  }
  if (!takes_a_frame(p))
    refuse("flight", "gap_length_s", number_text(p.gap_length_s), "a gap that leaves a frame of the flight");
  validate_camera(p.camera);
}

}  // namespace ilp::world
