// ST[03] housekeeping: lists of report structures (SIDs), their intervals, and the head of TM[3,25].
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/packets/tailoring.hpp"

namespace ilp {

namespace housekeeping {
inline constexpr std::uint8_t service = 3;
inline constexpr std::uint8_t enable = 5, disable = 6, report = 25, report_once = 27, set_interval = 31;
}  // namespace housekeeping

struct ReportInterval {
  std::uint64_t report_id = 0;
  TimeNs interval_ns = 0;
};
using ReportList = FixedVector<std::uint64_t, limits::max_list_items>;
using IntervalList = FixedVector<ReportInterval, limits::max_list_items>;

/// Decodes TC[3,5], [3,6] or [3,27]. Returns `request_malformed` (first value: offset in `data`) if the list is cut, is
/// empty or is followed by further octets, and `capacity_exceeded` if it is too long.
Status decode_report_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, ReportList& list);
void encode_report_list(const Tailoring& tailoring, const ReportList& list, ByteWriter& out);
/// Decodes TC[3,31]; intervals are rounded to milliseconds. As decode_report_list; also returns `invalid_argument` for
/// an interval that is negative, not a number, or above 2^32 - 1 ms.
Status decode_interval_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, IntervalList& list);
void encode_interval_list(const Tailoring& tailoring, const IntervalList& list, ByteWriter& out);
/// Appends the head of TM[3,25]. The caller appends the values of the report.
void encode_report_id(const Tailoring& tailoring, std::uint64_t report_id, ByteWriter& out);

}  // namespace ilp
