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

/// TC[3,5], [3,6], [3,27]. `request_malformed` (a = offset) for a list that is cut, is empty or is followed by further
/// octets; `capacity_exceeded`.
Status decode_report_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, ReportList& list);
void encode_report_list(const Tailoring& tailoring, const ReportList& list, ByteWriter& out);
/// TC[3,31]; also `invalid_argument` for an interval that is no time.
Status decode_interval_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, IntervalList& list);
void encode_interval_list(const Tailoring& tailoring, const IntervalList& list, ByteWriter& out);
/// The head of TM[3,25]; the values of the report's definition follow.
void encode_report_id(const Tailoring& tailoring, std::uint64_t report_id, ByteWriter& out);

}  // namespace ilp
