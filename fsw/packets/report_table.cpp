#include "fsw/packets/report_table.hpp"

#include <array>
#include <cstring>
#include <iterator>

#include "cfg/limits.hpp"
#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"

namespace ilp {
namespace {

template <typename Values>
struct Fields;

#include "fsw/records/rows_as_tables.inc"
// The rows.
#include "fsw/packets/reports.inc"

template <typename Values>
ReportInfo of_values(std::uint8_t id, const char* name, ReportSource source, std::uint16_t repeats,
                     const char* description) {
  constexpr auto count = static_cast<std::uint16_t>(std::size(Fields<Values>::table));
  return {id, name, description, source, RecordType::count, Fields<Values>::table, count, repeats};
}

ReportInfo of_record(std::uint8_t id, RecordType type, ReportSource source, const char* description) {
  const RecordInfo& info = record_info(type);
  return {id, info.name, description, source, type, info.fields, info.field_count, 1};
}

const std::array<ReportInfo, report_count> report_rows = {{
#define REPORT_OF_VALUES(id, name, values, repeats, description) \
  of_values<values>(id, #name, ReportSource::name, repeats, description),
#define REPORT_OF_RECORD(id, record, which, description) \
  of_record(id, RecordType::record, ReportSource::which, description),
#include "fsw/packets/reports.inc"
}};

}  // namespace

std::span<const ReportInfo> report_table() {
  return report_rows;
}

const ReportInfo* find_report(std::uint64_t id) {
  for (const ReportInfo& report : report_rows) {
    if (report.id == id) return &report;
  }
  return nullptr;
}

std::size_t report_bytes(const ReportInfo& report) {
  std::size_t bytes = 0;
  for (std::size_t f = 0; f < report.field_count; ++f) {
    const FieldInfo& field = report.fields[f];
    if (is_reported(field)) bytes += element_bytes(field.type) * field.count;
  }
  return bytes * report.repeats;
}

void write_report_values(const ReportInfo& report, const void* values, ByteWriter& out) {
  const auto* const bytes = static_cast<const std::uint8_t*>(values);
  for (std::size_t f = 0; f < report.field_count; ++f) {
    const FieldInfo& field = report.fields[f];
    if (!is_reported(field)) continue;
    const std::size_t width = element_bytes(field.type);
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::uint8_t* const element = bytes + field.offset + i * width;
      // In memory the number has the machine's byte order.
      std::uint64_t value = 0;
      if (width == 1) {
        value = *element;
      } else if (width == 2) {
        std::uint16_t number = 0;
        std::memcpy(&number, element, width);
        value = number;
      } else if (width == 4) {
        std::uint32_t number = 0;
        std::memcpy(&number, element, width);
        value = number;
      } else {
        std::memcpy(&value, element, width);
      }
      out.number(value, width);
    }
  }
}

}  // namespace ilp
