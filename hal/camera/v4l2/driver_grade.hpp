// Grades a camera's driver by its first frames: which of its reports can be trusted.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/time.hpp"

namespace ilp {

/// Bits of a verdict and of its events.
namespace finding {
inline constexpr std::uint32_t stamps_ahead = 1;      ///< after the clock at the frame's arrival
inline constexpr std::uint32_t stamps_stand = 2;      ///< do not increase
inline constexpr std::uint32_t stamps_elsewhere = 4;  ///< far from the monotonic clock: of another clock, or of none
inline constexpr std::uint32_t sequence_stands = 8;   ///< does not increase
inline constexpr std::uint32_t frames_missing = 16;   ///< by the sequence numbers, more than one of ten
inline constexpr std::uint32_t frames_damaged = 32;   ///< flagged as wrong, or with too few or too many bytes
inline constexpr std::uint32_t frames_stuck = 64;     ///< the picture never changes
inline constexpr std::uint32_t rate_differs = 128;    ///< by more than a tenth from the driver's own value
inline constexpr int count = 8;
/// Bit by bit.
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
  std::int32_t frames = 0;       ///< frames examined
  std::int64_t missing = 0;      ///< frames missing between them
  TimeNs period_ns = 0;          ///< measured
  bool stamps_believed = false;  ///< false: the time of arrival is a frame's time
  bool sequence_believed = false;
};

/// A frame as it arrived, in mission time.
struct FrameArrival {
  TimeNs stamp_ns = 0;           ///< the driver's
  TimeNs empty_ns = 0;           ///< latest time at which the driver had no frame: this one was finished later
  TimeNs now_ns = 0;             ///< when it was taken from the driver
  TimeNs arrival_ns = 0;         ///< best estimate between these two
  std::uint32_t sequence = 0;    ///< the driver's
  std::uint32_t sample_crc = 0;  ///< of some of its pixels
  bool uniform = false;          ///< these pixels are all the same
  bool damaged = false;
};

/// Why a stamp is suspect: finding::stamps_ahead, stamps_stand, stamps_elsewhere, or 0.
[[nodiscard]] std::uint32_t suspicion_of_stamp(const FrameArrival& frame, TimeNs previous_stamp_ns, TimeNs period_ns);

class DriverGrade {
 public:
  static constexpr std::int32_t frames_wanted = 30;
  /// A slow camera is graded by fewer frames after some seconds.
  static constexpr std::int32_t least_frames = 8;
  static constexpr TimeNs time_wanted_ns = 3 * ns_per_s;

  /// `stated_period_ns`: 0 when the driver states none.
  void begin(TimeNs stated_period_ns);
  void evaluate(const FrameArrival& frame);
  [[nodiscard]] bool complete() const;
  [[nodiscard]] CameraVerdict verdict() const;

 private:
  [[nodiscard]] TimeNs measured_period(const CameraVerdict& verdict) const;

  TimeNs stated_period_ns_ = 0;
  FrameArrival first_, latest_;
  std::int32_t frames_ = 0;  ///< whole ones
  std::int32_t damaged_ = 0;
  std::int32_t ahead_ = 0, stand_ = 0, elsewhere_ = 0, sequence_stands_ = 0;
  std::int64_t missing_ = 0;
  bool changed_ = false;
};

}  // namespace ilp
