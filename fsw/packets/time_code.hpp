// CCSDS time codes (301.0-B): CDS (days and milliseconds of UTC) and CUC (seconds and binary fractions), and the
// conversion of mission time to UTC.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "fsw/packets/bytes.hpp"

namespace ilp {

/// Nanoseconds of UTC since 1958-01-01T00:00:00, from 0 to 2^63 - 1 (the year 2250). Leap seconds are not counted:
/// every day has 86400 s, and the instants of a leap second have no values of their own.
using UtcNs = std::int64_t;

inline constexpr std::int64_t seconds_per_day = 86400;

/// Returns TAI - UTC in whole seconds at an instant of UTC. Before 1972 the value is 0, so that 1958-01-01 is the same
/// instant on both scales, as CUC requires.
[[nodiscard]] std::int64_t leap_seconds(UtcNs utc);
/// Converts UTC to nanoseconds of TAI since 1958-01-01; saturates at 2^63 - 1.
[[nodiscard]] std::int64_t tai_of_utc(UtcNs utc);
/// Converts nanoseconds of TAI since 1958-01-01 to UTC. All instants of a leap second become 00:00:00 of the next day.
[[nodiscard]] UtcNs utc_of_tai(std::int64_t tai);

enum class TimeCode : std::uint8_t {
  cds,         ///< UTC days since 1958 and milliseconds of the day
  cuc_ccsds,   ///< TAI seconds since 1958
  cuc_agency,  ///< elapsed seconds since the agency's epoch (TimeFormat::agency_epoch)
};

struct TimeFormat {
  TimeCode code = TimeCode::cds;
  bool p_field = true;             ///< preamble octet in front of the time, which names code and widths
  std::uint8_t day_octets = 2;     ///< CDS: 2 or 3
  std::uint8_t sub_ms_octets = 0;  ///< CDS: 0, 2 (microseconds) or 4 (picoseconds)
  std::uint8_t coarse_octets = 4;  ///< CUC: 1 to 4
  std::uint8_t fine_octets = 3;    ///< CUC: 0 to 3
  UtcNs agency_epoch = 0;          ///< for cuc_agency
};

/// The size of the longest time, with P-field, in any format.
inline constexpr std::size_t max_time_bytes = 12;

/// Octets of a time in this format, P-field included.
[[nodiscard]] std::size_t time_bytes(const TimeFormat& format);
/// The P-field that names the code and the widths of this format.
[[nodiscard]] std::uint8_t p_field_of(const TimeFormat& format);

/// Appends the time to `out`. CDS is truncated to its resolution, CUC is rounded. Returns `time_out_of_range` (first
/// value: day since 1958) if the format cannot hold the instant. `out` reports by ok() whether the time fitted.
Status encode_time(const TimeFormat& format, UtcNs utc, ByteWriter& out);
/// Clamps `utc` to the range of the format, so that no report fails because of its time.
[[nodiscard]] UtcNs nearest_time(const TimeFormat& format, UtcNs utc);
/// Reads a time. If the format has a P-field, code and widths are those of the P-field that is read, otherwise those of
/// `format`. Returns `packet_too_short` if octets are missing, `time_code_unknown` (first value: the P-field) if the
/// P-field names no code of TimeCode, and `time_out_of_range` (first value: day) if UtcNs cannot hold the instant or a
/// part of the day is out of range.
Status decode_time(const TimeFormat& format, ByteReader& in, UtcNs& utc);

/// Converts between mission time and UTC. Mission time runs like TAI.
class MissionTime {
 public:
  /// `epoch_s`: the instant of mission time 0, s of UTC since 1958 without leap seconds. A fraction is allowed.
  explicit MissionTime(double epoch_s);
  /// Saturates at both ends of the range of UtcNs.
  [[nodiscard]] UtcNs utc(TimeNs mission) const;
  [[nodiscard]] TimeNs mission(UtcNs utc) const { return tai_of_utc(utc) - epoch_tai_; }

 private:
  std::int64_t epoch_tai_;
};

}  // namespace ilp
