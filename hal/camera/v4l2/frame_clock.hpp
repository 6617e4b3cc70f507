// Estimates when a frame was exposed, from its driver's stamp and its arrival.
#pragma once

#include <cstdint>

#include "hal/camera/v4l2/driver_grade.hpp"

namespace ilp {

/// The source of a frame's time.
enum class TimeMeaning : std::uint8_t {
  start_of_exposure,  ///< the driver's stamp
  end_of_frame,       ///< the driver's stamp, minus a frame period or the given delay
  arrival,            ///< the time of arrival minus a frame period, because no stamp is trusted
};
[[nodiscard]] const char* time_meaning_text(TimeMeaning meaning);

class FrameClock {
 public:
  /// Begins a stream. `stamp_delay_ns`: from start of exposure to stamp, negative when not known.
  void begin(TimeNs stated_period_ns, TimeNs stamp_delay_ns);
  /// The driver is another one: nothing is known of its period and stamps.
  void forget() {
    period_ns_ = 0;
    stamps_believed_ = false;
  }
  void believe(const CameraVerdict& verdict);

  /// The arrival between the driver's last empty time and now, where the rhythm of the frames puts it. Frames that were
  /// taken together arrived one after the other.
  TimeNs arrival(TimeNs empty_ns, TimeNs now);
  /// Start of exposure, later than that of all earlier frames. `refused` when a stamp of a normally trusted driver was
  /// not used.
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
