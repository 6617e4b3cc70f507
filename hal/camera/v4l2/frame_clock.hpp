// When a frame was exposed, from what its driver stamps and when it arrived.
#pragma once

#include <cstdint>

#include "hal/camera/v4l2/driver_grade.hpp"

namespace ilp {

/// What a frame's time was made from.
enum class TimeMeaning : std::uint8_t {
  start_of_exposure,  ///< the driver's stamp
  end_of_frame,       ///< the driver's stamp, less a frame period or the delay that was given
  arrival,            ///< no believable stamp: when it came, less a frame period
};
[[nodiscard]] const char* time_meaning_text(TimeMeaning meaning);

class FrameClock {
 public:
  /// A new stream. `stamp_delay_ns`: from start of exposure to stamp, below 0 when not known.
  void begin(TimeNs stated_period_ns, TimeNs stamp_delay_ns);
  void believe(const CameraVerdict& verdict);

  /// Between the driver's last emptiness and now, where the rhythm of the frames puts it: frames that were taken in one
  /// go came one after the other.
  TimeNs arrival(TimeNs empty_ns, TimeNs now);
  /// Start of exposure, later than every one before. `refused` when a stamp that is usually believed was not.
  TimeNs exposure(const FrameArrival& frame, bool end_of_frame, TimeMeaning& meaning, bool& refused);

  [[nodiscard]] TimeNs period() const { return period_ns_; }

 private:
  void follow(const FrameArrival& frame);

  TimeNs period_ns_ = 0;
  TimeNs stamp_delay_ns_ = -1;
  bool stamps_believed_ = false;
  bool any_arrival_ = false, any_stamp_ = false, any_exposure_ = false;
  TimeNs arrival_ns_ = 0;
  TimeNs stamp_ns_ = 0;         ///< the latest one that fitted
  std::uint32_t sequence_ = 0;  ///< of its frame
  TimeNs exposure_ns_ = 0;
};

}  // namespace ilp
