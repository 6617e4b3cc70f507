// A source of images with times.
#pragma once

#include <cstdint>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

using FrameImage = FixedImage<std::uint8_t, limits::max_image_pixels, limits::spare_image_pixels>;

/// How an image is exposed. The gain is in thousandths of the sensor's own; 0 us: not known.
struct ExposureSetting {
  std::int64_t exposure_us = 0;
  std::int64_t gain_milli = 1000;

  [[nodiscard]] bool known() const { return exposure_us > 0; }
  bool operator==(const ExposureSetting&) const = default;
};

/// What a camera can be set to. A camera without a gain of its own has the same least and most.
struct ExposureRange {
  std::int64_t least_us = 0, most_us = 0;
  std::int64_t step_us = 1;
  std::int64_t least_gain_milli = 1000, most_gain_milli = 1000;
};

struct CameraFrame {
  TimeNs time_ns = 0;                                          ///< exposure time since the mission epoch
  std::int64_t sequence = 0;                                   ///< the camera's own counter
  double altitude = std::numeric_limits<double>::quiet_NaN();  ///< m above ground from ancillary data
  char name[64] = {};                                          ///< of the source, for reports
  ExposureSetting exposure = {};                               ///< with which it was taken, as far as the camera knows
};

class Camera {
 public:
  Camera() = default;
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  /// The next image taken at or before `now`. `not_ready` when there is none yet, `end_of_stream` when there will be no
  /// more. Any other status reports a lost frame (`frame` identifies it), and the next call takes the frame after it.
  virtual Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) = 0;
  /// A triggered camera exposes on command; any other one exposes at times of its own.
  [[nodiscard]] virtual bool triggered() const { return false; }
  /// The camera's counter starts over with every start of the software. The counter of a recording continues.
  [[nodiscard]] virtual bool restarts_counter() const { return false; }
  /// Sets the beginning of the next exposure, to the camera's own granularity, and replaces a pending trigger.
  /// `any_time`: at the camera's convenience. Cameras that are not triggered ignore it.
  virtual Status trigger(TimeNs time) {
    static_cast<void>(time);
    return {};
  }
  static constexpr TimeNs any_time = std::numeric_limits<TimeNs>::min();
  /// A frame belongs to a trigger if its exposure differs from the trigger by at most this much. 0: the camera exposes
  /// exactly at the trigger.
  [[nodiscard]] virtual TimeNs granularity() const { return 0; }
  /// Whether a triggered camera also exposes at times of its own, when its trigger is `any_time`.
  [[nodiscard]] virtual bool exposes_unasked() const { return granularity() > 0; }
  /// What set_exposure() takes. `camera_control_missing` for a camera whose exposure cannot be set (a = control, 0:
  /// all), `not_ready` while it is not known.
  virtual Status exposure_range(ExposureRange& range) {
    static_cast<void>(range);
    return StatusCode::camera_control_missing;
  }
  /// Sets exposure and gain of the images from now on; an image on its way may still have the earlier ones. `setting`
  /// becomes what the camera has made of it. The same codes.
  virtual Status set_exposure(ExposureSetting& setting) {
    static_cast<void>(setting);
    return StatusCode::camera_control_missing;
  }
  /// The time of the next image, if the source knows it; otherwise 0.
  virtual TimeNs next_due() const { return 0; }

 protected:
  ~Camera() = default;
};

}  // namespace ilp
