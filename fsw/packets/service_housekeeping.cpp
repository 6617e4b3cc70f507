#include "fsw/packets/service_housekeeping.hpp"

#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/result.hpp"

namespace ilp {
namespace {

constexpr double ms_per_s = 1000;
constexpr double longest_interval_ms = 4294967295.0;

Status malformed(const ByteReader& in) {
  return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
}

Status check_count(std::uint32_t count) {
  if (count == 0) return {StatusCode::request_malformed, 0};
  if (count > limits::max_list_items) {
    return {StatusCode::capacity_exceeded, count, static_cast<std::int64_t>(limits::max_list_items)};
  }
  return {};
}

/// Milliseconds, rounded to whole nanoseconds.
Result<TimeNs> read_interval(const Tailoring& tailoring, ByteReader& in) {
  if (!tailoring.interval_in_seconds) return in.u32() * ns_per_ms;
  const double ms = static_cast<double>(in.f32()) * ms_per_s;
  if (!(ms >= 0 && ms <= longest_interval_ms)) return out_of_range(Argument::interval);
  return static_cast<TimeNs>(std::floor(ms + 0.5)) * ns_per_ms;
}

/// `read_item` says whether an item is valid; `invalid_argument` if it is not.
template <typename List, typename ReadItem>
Status decode_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, List& list,
                   const ReadItem& read_item) {
  ByteReader in(data);
  list.clear();
  const std::uint32_t count = read_count(tailoring.report_count, in);
  if (!in.ok()) return malformed(in);
  ILP_TRY(check_count(count));
  for (std::uint32_t i = 0; i < count; ++i) {
    typename List::value_type item{};
    const bool good = read_item(in, item);
    if (!in.ok()) return malformed(in);
    if (!good) return out_of_range(Argument::interval);
    static_cast<void>(list.push_back(item));
  }
  return in.left() == 0 ? Status{} : malformed(in);
}

}  // namespace

Status decode_report_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, ReportList& list) {
  return decode_list(tailoring, data, list, [&](ByteReader& in, std::uint64_t& id) {
    id = in.number(tailoring.report_id);
    return true;
  });
}

void encode_report_list(const Tailoring& tailoring, const ReportList& list, ByteWriter& out) {
  write_count(tailoring.report_count, list.size(), out);
  for (const std::uint64_t id : list) out.number(id, tailoring.report_id);
}

Status decode_interval_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, IntervalList& list) {
  return decode_list(tailoring, data, list, [&](ByteReader& in, ReportInterval& item) {
    item.report_id = in.number(tailoring.report_id);
    const Result<TimeNs> interval = read_interval(tailoring, in);
    item.interval_ns = interval.value();
    return interval.ok();
  });
}

void encode_interval_list(const Tailoring& tailoring, const IntervalList& list, ByteWriter& out) {
  write_count(tailoring.report_count, list.size(), out);
  for (const ReportInterval& item : list) {
    out.number(item.report_id, tailoring.report_id);
    if (tailoring.interval_in_seconds) {
      out.f32(static_cast<float>(static_cast<double>(item.interval_ns) / static_cast<double>(ns_per_s)));
    } else {
      out.number(static_cast<std::uint64_t>(item.interval_ns / ns_per_ms), 4);
    }
  }
}

void encode_report_id(const Tailoring& tailoring, std::uint64_t report_id, ByteWriter& out) {
  out.number(report_id, tailoring.report_id);
}

}  // namespace ilp
