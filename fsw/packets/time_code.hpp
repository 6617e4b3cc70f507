// CCSDS time codes (301.0-B): CDS (days and milliseconds of UTC) and CUC (seconds and binary fractions), and the
// conversion of mission time to UTC.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "fsw/packets/bytes.hpp"

namespace ilp {

/// Nanoseconds of UTC since 1958-01-01, every day 86400 s long; 0 to 2^63 - 1 (the year 2250).
using UtcNs = std::int64_t;

inline constexpr std::int64_t seconds_per_day = 86400;

/// TAI - UTC at an instant of UTC, whole seconds. Before 1972 the value is 0, so that 1958-01-01 is the same instant on
/// both scales, as CUC requires.
[[nodiscard]] std::int64_t leap_seconds(UtcNs utc);
/// Nanoseconds of TAI since 1958-01-01, and back. An instant within a leap second maps to the second after it.
[[nodiscard]] std::int64_t tai_of_utc(UtcNs utc);
[[nodiscard]] UtcNs utc_of_tai(std::int64_t tai);

enum class TimeCode : std::uint8_t {
  cds,         ///< UTC days since 1958 and milliseconds of the day
  cuc_ccsds,   ///< TAI seconds since 1958
  cuc_agency,  ///< elapsed seconds since the agency's epoch
};

struct TimeFormat {
  TimeCode code = TimeCode::cds;
  bool p_field = true;
  std::uint8_t day_octets = 2;     ///< CDS: 2 or 3
  std::uint8_t sub_ms_octets = 0;  ///< CDS: 0, 2 (microseconds) or 4 (picoseconds)
  std::uint8_t coarse_octets = 4;  ///< CUC: 1 to 4
  std::uint8_t fine_octets = 3;    ///< CUC: 0 to 3
  UtcNs agency_epoch = 0;
};

inline constexpr std::size_t max_time_bytes = 12;

/// Octets of a time in this format, P-field included.
[[nodiscard]] std::size_t time_bytes(const TimeFormat& format);
[[nodiscard]] std::uint8_t p_field_of(const TimeFormat& format);

/// CDS is truncated to its resolution, CUC rounded. `time_out_of_range` for an instant that the format cannot hold.
Status encode_time(const TimeFormat& format, UtcNs utc, ByteWriter& out);
/// The instant nearest to `utc` that the format can hold, so that no report fails because of its time.
[[nodiscard]] UtcNs nearest_time(const TimeFormat& format, UtcNs utc);
/// With a P-field the octets name the code, which may be any of those above. `packet_too_short`, `time_code_unknown` (a
/// = P-field), `time_out_of_range`.
Status decode_time(const TimeFormat& format, ByteReader& in, UtcNs& utc);

/// Converts mission time to UTC from the instant at which it was 0 (`epoch_s` of UTC since 1958, without leap seconds;
/// it may have a fraction). Mission time runs like TAI.
class MissionTime {
 public:
  explicit MissionTime(double epoch_s);
  [[nodiscard]] UtcNs utc(TimeNs mission) const;
  [[nodiscard]] TimeNs mission(UtcNs utc) const { return tai_of_utc(utc) - epoch_tai_; }

 private:
  std::int64_t epoch_tai_;
};

}  // namespace ilp
