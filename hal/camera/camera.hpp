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

  /// The next image taken at or before `now`. `not_ready` when there is none yet, `end_of_stream` when there will be
  /// none. Any other status is a frame that was lost (`frame` says which): the next call goes on with the next one.
  virtual Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) = 0;
  /// A triggered camera exposes when it is told to; any other one exposes at times of its own.
  [[nodiscard]] virtual bool triggered() const { return false; }
  /// The camera's counter starts over with every start of the software; that of a recording goes on.
  [[nodiscard]] virtual bool counts_anew() const { return false; }
  /// The next exposure begins at `time`, to the camera's own granularity; replaces an earlier trigger that has not been
  /// carried out. `any_time`: at the camera's convenience. Other cameras ignore it.
  virtual Status trigger(TimeNs time) {
    static_cast<void>(time);
    return {};
  }
  static constexpr TimeNs any_time = std::numeric_limits<TimeNs>::min();
  /// A triggered camera's exposure may lie so far from its trigger and still is meant by it: an image farther off does
  /// not answer its trigger. 0: exposes at the very time.
  [[nodiscard]] virtual TimeNs granularity() const { return 0; }
  /// A triggered camera that also exposes at times of its own, when its trigger is `any_time`.
  [[nodiscard]] virtual bool exposes_unasked() const { return granularity() > 0; }
  /// When the next image is due, if the source knows; otherwise 0.
  virtual TimeNs next_due() const { return 0; }

 protected:
  ~Camera() = default;
};

}  // namespace ilp
