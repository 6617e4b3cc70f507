// A source of images with times.
#pragma once

#include <cstdint>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

using FrameImage = FixedImage<std::uint8_t, limits::max_image_pixels>;

struct CameraFrame {
  TimeNs time_ns = 0;                                          ///< exposure time since the mission epoch
  std::int64_t sequence = 0;                                   ///< the camera's own counter
  double altitude = std::numeric_limits<double>::quiet_NaN();  ///< m above ground from ancillary data
  char name[64] = {};                                          ///< of the source, for reports
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
  /// The time of the next image, if the source knows it; otherwise 0.
  virtual TimeNs next_due() const { return 0; }

 protected:
  ~Camera() = default;
};

}  // namespace ilp
