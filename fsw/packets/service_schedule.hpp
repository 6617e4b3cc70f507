// ST[11] time-based scheduling: telecommands with their release times.
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/tailoring.hpp"

namespace ilp {

namespace scheduling {
inline constexpr std::uint8_t service = 11;
inline constexpr std::uint8_t enable = 1, disable = 2, reset = 3, insert = 4, remove = 5, shift = 7, detail = 9,
                              detail_report = 10, summary = 12, summary_report = 13, shift_all = 15, detail_all = 16,
                              summary_all = 17;
}  // namespace scheduling

/// Identifies a request of service 11.
struct ScheduledId {
  std::uint16_t source = 0;
  std::uint16_t apid = 0;
  std::uint16_t count = 0;
  bool operator==(const ScheduledId&) const = default;
};
using ScheduledIdList = FixedVector<ScheduledId, limits::max_scheduled>;

struct ScheduleItem {
  std::uint32_t sub_schedule = 0;
  std::uint32_t group = 0;
  UtcNs release = 0;
  std::span<const std::uint8_t> packet;  ///< one complete telecommand; empty in summaries
  ScheduledId id;                        ///< only in summaries
};

/// Reads TC[11,4] item by item. Of each contained telecommand only the length is read; its content is not checked.
class InsertReader {
 public:
  InsertReader(const Tailoring& tailoring, std::span<const std::uint8_t> data);
  /// Reads the next item. Returns false at the end and at a fault; status() then gives `request_malformed` (first
  /// value: offset in the data) or the fault of decode_time.
  bool next(ScheduleItem& item);
  /// Number of items that the request announces.
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  const Tailoring& tailoring_;
  ByteReader in_;
  std::uint32_t sub_schedule_ = 0;
  std::uint32_t count_ = 0;
  std::uint32_t read_ = 0;
  Status status_;
};

/// Appends the head of TC[11,4]; `count` items follow.
void encode_insert_head(const Tailoring& tailoring, std::uint32_t sub_schedule, std::size_t count, ByteWriter& out);
/// Appends one item of TC[11,4]. Returns `time_out_of_range` if the tailoring cannot hold the release time.
Status encode_insert_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out);

/// Decodes TC[11,5], or another request that is a list of identifiers. Returns `request_malformed` (first value: offset
/// in `data`) if the list is cut, is empty or is followed by further octets, and `capacity_exceeded` if it is too long.
Status decode_scheduled_ids(const Tailoring& tailoring, std::span<const std::uint8_t> data, ScheduledIdList& ids);
/// Decodes TC[11,7]: `ms` is the shift of the release times, ms. Returns the faults of decode_scheduled_ids.
Status decode_shift(const Tailoring& tailoring, std::span<const std::uint8_t> data, std::int32_t& ms,
                    ScheduledIdList& ids);
/// Decodes TC[11,15]: the shift of all release times, ms. Returns `request_malformed` if the data are no four octets.
Status decode_shift_all(std::span<const std::uint8_t> data, std::int32_t& ms);

/// Appends the head of TM[11,13] and TM[11,10]; `count` items follow.
void encode_report_head(const Tailoring& tailoring, std::size_t count, ByteWriter& out);
/// Appends one item of TM[11,13]: release time and identifier.
Status encode_summary_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out);
/// Appends one item of TM[11,10]: release time and telecommand.
Status encode_detail_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out);

/// The identifier of a telecommand, from its headers.
[[nodiscard]] ScheduledId scheduled_id(const Telecommand& request);

}  // namespace ilp
