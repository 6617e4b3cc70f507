// Finds out from the first frames of a camera which reports of its driver can be trusted.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/time.hpp"

namespace ilp {

/// Bits of CameraVerdict::findings and of the events about it. Stamps, sequence numbers and missing frames count if
/// more than a tenth of the frames is affected.
namespace finding {
inline constexpr std::uint32_t stamps_ahead = 1;      ///< time stamps later than the frame's arrival
inline constexpr std::uint32_t stamps_stand = 2;      ///< time stamps that do not increase
inline constexpr std::uint32_t stamps_elsewhere = 4;  ///< time stamps far from the monotonic clock
inline constexpr std::uint32_t sequence_stands = 8;   ///< sequence numbers that do not increase
inline constexpr std::uint32_t frames_missing = 16;   ///< frames missing by the sequence numbers
inline constexpr std::uint32_t frames_damaged = 32;   ///< frames flagged as wrong, or with too few or too many bytes
inline constexpr std::uint32_t frames_stuck = 64;     ///< the picture never changes
inline constexpr std::uint32_t rate_differs = 128;    ///< the frame period differs by over a tenth from the stated one
inline constexpr int count = 8;
/// Text of each bit, from the least significant one.
inline constexpr const char* texts[count] = {"time stamps ahead of the clock",
                                             "time stamps that do not increase",
                                             "time stamps of another clock than the monotonic one",
                                             "sequence numbers that do not increase",
                                             "frames missing",
                                             "damaged frames",
                                             "the same picture all the time",
                                             "another rate than stated"};
}  // namespace finding

struct CameraVerdict {
  std::uint32_t findings = 0;
  std::int32_t frames = 0;         ///< undamaged frames examined; 0: there is no verdict
  std::int64_t missing = 0;        ///< frames missing between them, by the sequence numbers
  TimeNs period_ns = 0;            ///< measured frame period
  bool stamps_believed = false;    ///< the driver's time stamps are used; else the time of arrival
  bool sequence_believed = false;  ///< the driver's sequence numbers are used
};

/// What is known of a frame that the driver has returned. All times are mission times.
struct FrameArrival {
  TimeNs stamp_ns = 0;           ///< the driver's time stamp
  TimeNs empty_ns = 0;           ///< latest time at which the driver had no frame; this frame was finished later
  TimeNs now_ns = 0;             ///< when the frame was taken from the driver
  TimeNs arrival_ns = 0;         ///< best estimate of when it was finished, between `empty_ns` and `now_ns`
  std::uint32_t sequence = 0;    ///< the driver's sequence number
  std::uint32_t sample_crc = 0;  ///< CRC of some of its pixels
  bool uniform = false;          ///< all of these pixels have the same value
  bool damaged = false;
};

/// Returns why a stamp is suspect: finding::stamps_ahead, stamps_stand or stamps_elsewhere; 0: it is not. `period_ns`
/// is the frame period; 0: not known.
[[nodiscard]] std::uint32_t suspicion_of_stamp(const FrameArrival& frame, TimeNs previous_stamp_ns, TimeNs period_ns);

class DriverGrade {
 public:
  /// Frames for a verdict.
  static constexpr std::int32_t frames_wanted = 30;
  /// For a slow camera, this number of frames suffices after time_wanted_ns.
  static constexpr std::int32_t least_frames = 8;
  static constexpr TimeNs time_wanted_ns = 3 * ns_per_s;

  /// Begins with no frames. `stated_period_ns` is the frame period that the driver states; 0: none.
  void begin(TimeNs stated_period_ns);
  /// Takes the next frame into account.
  void evaluate(const FrameArrival& frame);
  /// Whether there are enough frames for a verdict.
  [[nodiscard]] bool complete() const;
  /// Returns the verdict on the frames until now.
  [[nodiscard]] CameraVerdict verdict() const;

 private:
  [[nodiscard]] TimeNs measured_period(const CameraVerdict& verdict) const;

  TimeNs stated_period_ns_ = 0;
  FrameArrival first_, latest_;
  std::int32_t frames_ = 0;                                                   ///< undamaged frames
  std::int32_t damaged_ = 0;                                                  ///< damaged frames
  std::int32_t ahead_ = 0, stand_ = 0, elsewhere_ = 0, sequence_stands_ = 0;  ///< frames with each finding
  std::int64_t missing_ = 0;
  bool changed_ = false;  ///< two frames had different pixels, or one was uniform
};

}  // namespace ilp
