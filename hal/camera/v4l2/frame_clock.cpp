#include "hal/camera/v4l2/frame_clock.hpp"

#include <algorithm>

namespace ilp {

const char* time_meaning_text(TimeMeaning meaning) {
  switch (meaning) {
    case TimeMeaning::start_of_exposure:
      return "start-of-exposure";
    case TimeMeaning::end_of_frame:
      return "end-of-frame";
    case TimeMeaning::arrival:
      return "arrival";
  }
  return "";
}

void FrameClock::begin(TimeNs stated_period_ns, TimeNs stamp_delay_ns) {
  // Times keep rising across a new start of the stream; everything else starts over.
  any_arrival_ = any_stamp_ = false;
  if (stated_period_ns > 0) period_ns_ = stated_period_ns;
  stamp_delay_ns_ = stamp_delay_ns;
}

void FrameClock::believe(const CameraVerdict& verdict) {
  stamps_believed_ = verdict.stamps_believed;
  if (verdict.period_ns > 0) period_ns_ = verdict.period_ns;
}

TimeNs FrameClock::arrival(TimeNs empty_ns, TimeNs now) {
  const TimeNs expected = any_arrival_ && period_ns_ > 0 ? arrival_ns_ + period_ns_ : now;
  // After a pause, the time at which the driver's queue was last empty is long past; no frame can have come before it.
  arrival_ns_ = std::clamp(expected, std::min(empty_ns, now), now);
  any_arrival_ = true;
  return arrival_ns_;
}

void FrameClock::follow(const FrameArrival& frame) {
  // An automatic exposure changes the rate in the dark.
  const bool next = any_stamp_ && frame.sequence - sequence_ == 1;
  if (next && stamps_believed_) period_ns_ += (frame.stamp_ns - stamp_ns_ - period_ns_) / 16;
  stamp_ns_ = frame.stamp_ns;
  sequence_ = frame.sequence;
  any_stamp_ = true;
}

TimeNs FrameClock::exposure(const FrameArrival& frame, bool end_of_frame, TimeMeaning& meaning, bool& refused) {
  const TimeNs before = any_stamp_ ? stamp_ns_ : frame.stamp_ns - 1;
  const bool fits = suspicion_of_stamp(frame, before, period_ns_) == 0;
  refused = stamps_believed_ && !fits;
  if (fits) follow(frame);
  TimeNs time = 0;
  if (stamps_believed_ && fits) {
    meaning = end_of_frame ? TimeMeaning::end_of_frame : TimeMeaning::start_of_exposure;
    const TimeNs usual_delay = end_of_frame ? period_ns_ : 0;
    time = frame.stamp_ns - (stamp_delay_ns_ >= 0 ? stamp_delay_ns_ : usual_delay);
  } else {
    meaning = TimeMeaning::arrival;
    time = frame.arrival_ns - period_ns_;
  }
  if (any_exposure_) time = std::max(time, exposure_ns_ + 1);
  any_exposure_ = true;
  exposure_ns_ = time;
  return time;
}

}  // namespace ilp
