// The housekeeping reports of service 3, as fsw/packets/reports.inc lists them, and their values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

#include "fsw/packets/bytes.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

/// The source of a report's values: a struct of the report's name, or a record.
enum class ReportSource : std::uint8_t {
#define REPORT_OF_VALUES(id, name, ...) name,
#include "fsw/packets/reports.inc"
  first,  ///< the record with id 1
  newest  ///< the record with the largest id
};

#include "fsw/records/rows_as_structs.inc"
// The rows.
#include "fsw/packets/reports.inc"

/// A report contains its fields `repeats` times, in the order of the table, big-endian and without padding. Texts and
/// blobs are left out.
struct ReportInfo {
  std::uint8_t id;  ///< permanent SID; below report_id_limit
  const char* name;
  const char* description;
  ReportSource source;
  RecordType record;  ///< for ReportSource::first and newest
  const FieldInfo* fields;
  std::uint16_t field_count;
  std::uint16_t repeats;
};

/// All reports, in the order in which they are sent when several are due.
[[nodiscard]] std::span<const ReportInfo> report_table();
inline constexpr std::uint8_t report_ids[] = {
#define REPORT_OF_VALUES(id, ...) (id),
#define REPORT_OF_RECORD(id, ...) (id),
#include "fsw/packets/reports.inc"
};
inline constexpr std::size_t report_count = std::size(report_ids);
/// All SIDs are below this limit.
inline constexpr std::size_t report_id_limit = 64;
/// Returns the null pointer when no report has this SID.
[[nodiscard]] const ReportInfo* find_report(std::uint64_t id);

[[nodiscard]] constexpr bool is_reported(const FieldInfo& field) {
  return field.type != FieldType::text && field.type != FieldType::blob;
}
/// Number of octets of the report's values, without the SID.
[[nodiscard]] std::size_t report_bytes(const ReportInfo& report);
/// Appends the reported fields of the struct at `values`, once.
void write_report_values(const ReportInfo& report, const void* values, ByteWriter& out);

}  // namespace ilp
