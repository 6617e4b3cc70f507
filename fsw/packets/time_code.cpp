#include "fsw/packets/time_code.hpp"

#include <algorithm>
#include <limits>

namespace ilp {
namespace {

constexpr std::int64_t ns_per_day = seconds_per_day * ns_per_s;

/// Days since 1958 from which on TAI - UTC has the value (IERS Bulletin C; 1972-01-01 is day 5113).
struct LeapSecond {
  std::int32_t day;
  std::int32_t seconds;
};
constexpr LeapSecond leaps[] = {{5113, 10},  {5295, 11},  {5479, 12},  {5844, 13},  {6209, 14},  {6574, 15},
                                {6940, 16},  {7305, 17},  {7670, 18},  {8035, 19},  {8582, 20},  {8947, 21},
                                {9312, 22},  {10043, 23}, {10957, 24}, {11688, 25}, {12053, 26}, {12600, 27},
                                {12965, 28}, {13330, 29}, {13879, 30}, {14426, 31}, {14975, 32}, {17532, 33},
                                {18628, 34}, {19905, 35}, {21000, 36}, {21550, 37}};

constexpr std::int64_t latest_instant = std::numeric_limits<std::int64_t>::max();

Status out_of_range(UtcNs utc) {
  return {StatusCode::time_out_of_range, utc / ns_per_day};
}

Status encode_cds(const TimeFormat& format, UtcNs utc, ByteWriter& out) {
  const std::int64_t day = utc / ns_per_day;
  const std::int64_t of_day = utc % ns_per_day;
  if (format.day_octets == 2 && day > 0xFFFF) return out_of_range(utc);
  out.number(static_cast<std::uint64_t>(day), format.day_octets);
  out.u32(static_cast<std::uint32_t>(of_day / ns_per_ms));
  const std::int64_t of_ms = of_day % ns_per_ms;
  if (format.sub_ms_octets == 2) out.u16(static_cast<std::uint16_t>(of_ms / ns_per_us));
  if (format.sub_ms_octets == 4) out.u32(static_cast<std::uint32_t>(of_ms * 1000));
  return {};
}

Status encode_cuc(const TimeFormat& format, UtcNs utc, ByteWriter& out) {
  const std::int64_t epoch = format.code == TimeCode::cuc_agency ? tai_of_utc(format.agency_epoch) : 0;
  const std::int64_t elapsed = tai_of_utc(utc) - epoch;
  if (elapsed < 0) return out_of_range(utc);
  const unsigned bits = 8U * format.fine_octets;
  std::uint64_t seconds = static_cast<std::uint64_t>(elapsed / ns_per_s);
  const std::uint64_t ns = static_cast<std::uint64_t>(elapsed % ns_per_s);
  // 30 bits of nanoseconds and at most 24 of the fraction.
  std::uint64_t fine = ((ns << bits) + ns_per_s / 2) / ns_per_s;
  seconds += fine >> bits;
  fine &= (std::uint64_t{1} << bits) - 1;
  if ((seconds >> (8U * format.coarse_octets)) != 0) return out_of_range(utc);
  out.number(seconds, format.coarse_octets);
  out.number(fine, format.fine_octets);
  return {};
}

Status decode_cds(const TimeFormat& format, ByteReader& in, UtcNs& utc) {
  const std::uint64_t day = in.number(format.day_octets);
  const std::uint64_t ms = in.u32();
  const std::uint64_t sub_ms = in.number(format.sub_ms_octets);
  if (day >= static_cast<std::uint64_t>(latest_instant / ns_per_day)) {
    return {StatusCode::time_out_of_range, static_cast<std::int64_t>(day)};
  }
  // A later millisecond of the day would be an instant of the next day, except for a leap second.
  if (ms >= static_cast<std::uint64_t>(seconds_per_day + 1) * 1000) {
    return {StatusCode::time_out_of_range, static_cast<std::int64_t>(day), static_cast<std::int64_t>(ms)};
  }
  const std::uint64_t most = format.sub_ms_octets == 2 ? 1000 : 1'000'000'000;
  if (format.sub_ms_octets != 0 && sub_ms >= most) {
    return {StatusCode::time_out_of_range, static_cast<std::int64_t>(day), static_cast<std::int64_t>(sub_ms)};
  }
  const std::uint64_t ns = format.sub_ms_octets == 2 ? sub_ms * 1000 : sub_ms / 1000;
  utc = static_cast<std::int64_t>(day) * ns_per_day + static_cast<std::int64_t>(ms) * ns_per_ms +
        static_cast<std::int64_t>(format.sub_ms_octets == 0 ? 0 : ns);
  return {};
}

Status decode_cuc(const TimeFormat& format, ByteReader& in, UtcNs& utc) {
  const auto seconds = static_cast<std::int64_t>(in.number(format.coarse_octets));
  const std::uint64_t fine = in.number(format.fine_octets);
  const unsigned bits = 8U * format.fine_octets;
  const std::uint64_t half = bits == 0 ? 0 : std::uint64_t{1} << (bits - 1);
  const auto ns = static_cast<std::int64_t>((fine * ns_per_s + half) >> bits);
  const std::int64_t epoch = format.code == TimeCode::cuc_agency ? tai_of_utc(format.agency_epoch) : 0;
  const std::int64_t elapsed = seconds * ns_per_s + ns;  // at most 2^32 s
  if (epoch > latest_instant - elapsed) return {StatusCode::time_out_of_range, seconds / seconds_per_day};
  utc = utc_of_tai(epoch + elapsed);
  return {};
}

/// Interprets the P-field of the codes known here.
bool format_of(std::uint8_t p_field, TimeFormat& format) {
  const unsigned id = p_field >> 4U;  // with the extension flag, which none of them has
  if (id == 1 || id == 2) {
    format.code = id == 1 ? TimeCode::cuc_ccsds : TimeCode::cuc_agency;
    format.coarse_octets = static_cast<std::uint8_t>(((p_field >> 2U) & 3U) + 1);
    format.fine_octets = p_field & 3U;
    return true;
  }
  if (id != 4 || (p_field & 8U) != 0 || (p_field & 3U) == 3) return false;
  format.code = TimeCode::cds;
  format.day_octets = (p_field & 4U) != 0 ? 3 : 2;
  format.sub_ms_octets = static_cast<std::uint8_t>(2 * (p_field & 3U));
  return true;
}

}  // namespace

std::int64_t leap_seconds(UtcNs utc) {
  const std::int64_t day = utc / ns_per_day;
  std::int64_t seconds = 0;
  for (const LeapSecond& leap : leaps) {
    if (day >= leap.day) seconds = leap.seconds;
  }
  return seconds;
}

std::int64_t tai_of_utc(UtcNs utc) {
  const std::int64_t leap_ns = leap_seconds(utc) * ns_per_s;
  return utc > latest_instant - leap_ns ? latest_instant : utc + leap_ns;
}

UtcNs utc_of_tai(std::int64_t tai) {
  std::int64_t utc = tai;
  for (const LeapSecond& leap : leaps) {
    const std::int64_t begin = leap.day * ns_per_day;
    if (tai >= begin + leap.seconds * ns_per_s) {
      utc = tai - leap.seconds * ns_per_s;
    } else if (utc >= begin) {
      return begin;
    }
  }
  return utc;
}

std::size_t time_bytes(const TimeFormat& format) {
  const std::size_t head = format.p_field ? 1 : 0;
  if (format.code == TimeCode::cds) return head + format.day_octets + 4U + format.sub_ms_octets;
  return head + format.coarse_octets + format.fine_octets;
}

std::uint8_t p_field_of(const TimeFormat& format) {
  if (format.code == TimeCode::cds) {
    return static_cast<std::uint8_t>(0x40U | (format.day_octets == 3 ? 4U : 0U) | (format.sub_ms_octets / 2U));
  }
  const unsigned id = format.code == TimeCode::cuc_ccsds ? 0x10U : 0x20U;
  return static_cast<std::uint8_t>(id | ((format.coarse_octets - 1U) << 2U) | format.fine_octets);
}

Status encode_time(const TimeFormat& format, UtcNs utc, ByteWriter& out) {
  if (utc < 0) return out_of_range(utc);
  if (format.p_field) out.u8(p_field_of(format));
  return format.code == TimeCode::cds ? encode_cds(format, utc, out) : encode_cuc(format, utc, out);
}

UtcNs nearest_time(const TimeFormat& format, UtcNs utc) {
  if (format.code == TimeCode::cds) {
    constexpr std::int64_t days = 0x10000;
    return std::clamp<UtcNs>(utc, 0, format.day_octets == 2 ? days * ns_per_day - 1 : latest_instant);
  }
  const UtcNs begin = format.code == TimeCode::cuc_agency ? format.agency_epoch : 0;
  // A second less than the octets allow, because rounding may use it up.
  const std::int64_t seconds = (std::int64_t{1} << (8U * format.coarse_octets)) - 2;
  const std::int64_t epoch = format.code == TimeCode::cuc_agency ? tai_of_utc(begin) : 0;
  const UtcNs end =
      epoch > latest_instant - seconds * ns_per_s ? latest_instant : utc_of_tai(epoch + seconds * ns_per_s);
  return std::clamp(utc, begin, std::max(begin, end));
}

Status decode_time(const TimeFormat& format, ByteReader& in, UtcNs& utc) {
  TimeFormat found = format;
  if (format.p_field) {
    const std::uint8_t p_field = in.u8();
    if (in.ok() && !format_of(p_field, found)) return {StatusCode::time_code_unknown, p_field};
  }
  const std::size_t needed = time_bytes(found) - (found.p_field ? 1U : 0U);
  if (!in.ok() || in.left() < needed) {
    return {StatusCode::packet_too_short, static_cast<std::int64_t>(in.left()), static_cast<std::int64_t>(needed)};
  }
  return found.code == TimeCode::cds ? decode_cds(found, in, utc) : decode_cuc(found, in, utc);
}

MissionTime::MissionTime(double epoch_s) : epoch_tai_(0) {
  const auto seconds = static_cast<std::int64_t>(epoch_s);
  const double fraction = epoch_s - static_cast<double>(seconds);
  epoch_tai_ = tai_of_utc(seconds * ns_per_s + static_cast<std::int64_t>(fraction * 1e9));
}

UtcNs MissionTime::utc(TimeNs mission) const {
  const std::int64_t tai = mission > latest_instant - epoch_tai_ ? latest_instant : epoch_tai_ + mission;
  return utc_of_tai(std::max<std::int64_t>(tai, 0));
}

}  // namespace ilp
