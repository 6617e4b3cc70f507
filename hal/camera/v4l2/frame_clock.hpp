// Estimates when the exposure of a frame began, from the driver's time stamp and the frame's arrival.
#pragma once

#include <cstdint>

#include "hal/camera/v4l2/driver_grade.hpp"

namespace ilp {

/// The source of a frame's time.
enum class TimeMeaning : std::uint8_t {
  start_of_exposure,  ///< the driver's stamp
  end_of_frame,       ///< the driver's stamp, minus a frame period or the given delay
  arrival,            ///< the time of arrival minus a frame period, because the stamp is not trusted
};
/// Text for names of frames: start-of-exposure, end-of-frame or arrival.
[[nodiscard]] const char* time_meaning_text(TimeMeaning meaning);

class FrameClock {
 public:
  /// Begins a stream. `stated_period_ns` is the frame period that the driver states; 0: none. `stamp_delay_ns` is the
  /// time from the start of exposure to the driver's stamp; negative: not known.
  void begin(TimeNs stated_period_ns, TimeNs stamp_delay_ns);
  /// For another driver: forgets the frame period, and trusts no stamp until believe().
  void forget() {
    period_ns_ = 0;
    stamps_believed_ = false;
  }
  /// Takes the frame period, and whether stamps are trusted, from the verdict on the driver.
  void believe(const CameraVerdict& verdict);

  /// Estimates when a frame arrived: one frame period after the frame before it, but not before `empty_ns` and not
  /// after `now`. `empty_ns` is the latest time at which the driver had no frame. The frames of a queue that is emptied
  /// at once thus get different times.
  TimeNs arrival(TimeNs empty_ns, TimeNs now);
  /// Estimates the start of exposure; it is later than that of all earlier frames. `end_of_frame` states that the
  /// driver stamps the end of the frame. `meaning` becomes the source of the time. `refused` becomes true if the stamp
  /// of a trusted driver was suspect and not used.
  TimeNs exposure(const FrameArrival& frame, bool end_of_frame, TimeMeaning& meaning, bool& refused);

  /// Estimated frame period; 0: not known.
  [[nodiscard]] TimeNs period() const { return period_ns_; }

 private:
  /// Updates the frame period from the stamp of this frame.
  void follow(const FrameArrival& frame);

  TimeNs period_ns_ = 0;
  TimeNs stamp_delay_ns_ = -1;
  bool stamps_believed_ = false;
  bool any_arrival_ = false, any_stamp_ = false, any_exposure_ = false;
  TimeNs arrival_ns_ = 0;       ///< arrival of the latest frame
  TimeNs stamp_ns_ = 0;         ///< latest stamp that was not suspect
  std::uint32_t sequence_ = 0;  ///< sequence number of the frame with that stamp
  TimeNs exposure_ns_ = 0;      ///< start of exposure of the latest frame
};

}  // namespace ilp
