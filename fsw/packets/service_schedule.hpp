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
  std::span<const std::uint8_t> packet;  ///< a whole telecommand; empty in summaries
  ScheduledId id;                        ///< in summaries
};

/// Reads TC[11,4] item by item. The header of a packet gives its length; its content is not checked.
class InsertReader {
 public:
  InsertReader(const Tailoring& tailoring, std::span<const std::uint8_t> data);
  /// Returns false at the end, and at a fault, which `status` gives: `request_malformed` (a = offset), the faults of
  /// times.
  bool next(ScheduleItem& item);
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

/// Head and items of TC[11,4].
void encode_insert_head(const Tailoring& tailoring, std::uint32_t sub_schedule, std::size_t count, ByteWriter& out);
Status encode_insert_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out);

/// TC[11,5]. `request_malformed` (a = offset), `capacity_exceeded`.
Status decode_scheduled_ids(const Tailoring& tailoring, std::span<const std::uint8_t> data, ScheduledIdList& ids);
/// TC[11,7] with an offset in milliseconds and requests, or TC[11,15] with the offset alone.
Status decode_shift(const Tailoring& tailoring, std::span<const std::uint8_t> data, std::int32_t& ms,
                    ScheduledIdList& ids);
Status decode_shift_all(std::span<const std::uint8_t> data, std::int32_t& ms);

/// TM[11,13] and TM[11,10]: a count, then items.
void encode_report_head(const Tailoring& tailoring, std::size_t count, ByteWriter& out);
Status encode_summary_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out);
Status encode_detail_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out);

/// The identifier from the headers of the request itself.
[[nodiscard]] ScheduledId scheduled_id(const Telecommand& request);

}  // namespace ilp
