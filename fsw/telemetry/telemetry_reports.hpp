// The housekeeping reports of service 3: which values each of them holds. Their layouts follow from tables of fields;
// the interface document and the Telemetry component follow from these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/link/bytes.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

/// Where the values of a report come from.
enum class ReportSource : std::uint8_t {
  status,      ///< PackageStatus
  link,        ///< LinkCounts
  components,  ///< ComponentHealth of every component, in the order of the schedule
  first,       ///< the record with id 1
  newest       ///< the record with the largest id
};

/// The package as a whole.
struct PackageStatus {
  std::int64_t mission_time_ns = 0;
  std::uint8_t version_major = 0, version_minor = 0, version_patch = 0;
  std::uint8_t contact = 0;
  std::uint32_t parameters_crc32 = 0;
  std::uint32_t frames_run = 0, frame_overruns = 0;
  std::uint32_t events = 0, events_untold = 0, events_disabled = 0;
};

/// Packets and PDUs since the last start.
struct LinkCounts {
  std::uint32_t received = 0, sent = 0, malformed = 0, unknown_apid = 0, refused = 0, dropped = 0;
  std::uint32_t reports_sent = 0, reports_lost = 0, reports_waiting = 0;
  std::uint32_t pdus_in = 0, pdus_out = 0, pdus_rejected = 0, pdus_ignored = 0;
  std::uint32_t files_delivered = 0, files_refused = 0, files_cancelled = 0;
};

struct ComponentHealth {
  std::uint32_t steps = 0, overruns = 0, restarts = 0, faults = 0;
  std::int64_t busy_ns = 0, longest_ns = 0;
};

/// A report is its fields in table order, big-endian, without padding, `repeats` times; texts and blobs are left out.
struct ReportInfo {
  std::uint8_t id;  ///< SID, for ever; below report_id_limit
  const char* name;
  const char* description;
  ReportSource source;
  RecordType record;  ///< of `first` and `newest`
  const FieldInfo* fields;
  std::uint16_t field_count;
  std::uint16_t repeats;
};

/// In the order in which they go when several are due.
[[nodiscard]] std::span<const ReportInfo> report_table();
inline constexpr std::size_t report_count = 20;
/// SIDs are below it.
inline constexpr std::size_t report_id_limit = 64;
/// The null pointer when no report has this SID.
[[nodiscard]] const ReportInfo* find_report(std::uint64_t id);

[[nodiscard]] constexpr bool is_reported(const FieldInfo& field) {
  return field.type != FieldType::text && field.type != FieldType::blob;
}
/// Octets of its values, behind the SID.
[[nodiscard]] std::size_t report_bytes(const ReportInfo& report);
/// The fields of one struct.
void write_report_values(const ReportInfo& report, const void* values, ByteWriter& out);

}  // namespace ilp
