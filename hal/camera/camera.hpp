// Interface of a camera: images with exposure times, triggering and exposure control.
#pragma once

#include <cstdint>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

using FrameImage = FixedImage<std::uint8_t, limits::max_image_pixels, limits::spare_image_pixels>;

/// Exposure time and gain of an image.
struct ExposureSetting {
  std::int64_t exposure_us = 0;    ///< 0: not known
  std::int64_t gain_milli = 1000;  ///< thousandths of the sensor's least gain

  [[nodiscard]] bool known() const { return exposure_us > 0; }
  bool operator==(const ExposureSetting&) const = default;
};

/// Settings that a camera accepts.
struct ExposureRange {
  std::int64_t least_us = 0, most_us = 0;
  std::int64_t step_us = 1;
  std::int64_t least_gain_milli = 1000, most_gain_milli = 1000;  ///< equal if the gain cannot be set
};

struct CameraFrame {
  TimeNs time_ns = 0;                                          ///< mission time of the exposure
  std::int64_t sequence = 0;                                   ///< number of the frame by the camera's counter
  double altitude = std::numeric_limits<double>::quiet_NaN();  ///< m above ground from ancillary data; NaN: not known
  char name[64] = {};                                          ///< name of the frame, for reports
  ExposureSetting exposure = {};                               ///< exposure of the frame, if the camera knows it
};

class Camera {
 public:
  Camera() = default;
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  /// Reads the next image that was exposed at or before `now`. Returns `not_ready` if there is none yet and
  /// `end_of_stream` if no more will come. Any other status reports a lost frame, which `frame` identifies; the next
  /// call continues with the frame after it.
  virtual Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) = 0;
  /// True for a camera that exposes on command, false for one that exposes at times of its own.
  [[nodiscard]] virtual bool triggered() const { return false; }
  /// True if CameraFrame::sequence starts again with every start of the software; in a recording it continues.
  [[nodiscard]] virtual bool restarts_counter() const { return false; }
  /// Sets the mission time at which the next exposure begins, to within granularity(), and replaces a pending trigger.
  /// With `any_time` the camera chooses the time. Cameras that are not triggered ignore the call.
  virtual Status trigger(TimeNs time) {
    static_cast<void>(time);
    return {};
  }
  static constexpr TimeNs any_time = std::numeric_limits<TimeNs>::min();
  /// Largest difference in ns between a trigger and the exposure of the frame that belongs to it. 0: the camera exposes
  /// exactly at the trigger.
  [[nodiscard]] virtual TimeNs granularity() const { return 0; }
  /// Whether a triggered camera also exposes at times of its own while its trigger is `any_time`.
  [[nodiscard]] virtual bool exposes_unasked() const { return granularity() > 0; }
  /// Reads the settings that set_exposure() accepts. Returns `camera_control_missing` (first value: the control; 0:
  /// all) if the exposure cannot be set, `not_ready` while the range is not known.
  virtual Status exposure_range(ExposureRange& range) {
    static_cast<void>(range);
    return StatusCode::camera_control_missing;
  }
  /// Sets exposure and gain of later images; an image in progress may still have the previous setting. Replaces
  /// `setting` by the values that the camera has applied. Returns the same statuses as exposure_range().
  virtual Status set_exposure(ExposureSetting& setting) {
    static_cast<void>(setting);
    return StatusCode::camera_control_missing;
  }
  /// Mission time of the next image; 0: not known.
  virtual TimeNs next_due() const { return 0; }

 protected:
  ~Camera() = default;
};

}  // namespace ilp
