#include "sim/tools/docgen/records_document.hpp"

#include "cfg/schedule.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/records/records.hpp"
#include "fsw/records/serial.hpp"
#include "sim/tools/docgen/markdown.hpp"

namespace ilp::docgen {

const char* field_type_name(FieldType type) {
  switch (type) {
    case FieldType::u8:
      return "u8";
    case FieldType::u16:
      return "u16";
    case FieldType::u32:
      return "u32";
    case FieldType::i32:
      return "i32";
    case FieldType::i64:
      return "i64";
    case FieldType::f32:
      return "f32";
    case FieldType::f64:
      return "f64";
    case FieldType::text:
      return "text";
    case FieldType::blob:
      return "blob";
  }
  return "?";
}

std::string declaration_cell(const FieldInfo& field) {
  std::string text = code(field.name) + " " + field_type_name(field.type);
  if (field.count > 1) text += "[" + std::to_string(field.count) + "]";
  return field.unit[0] == 0 ? text : text + " " + cell(field.unit);
}

namespace {

std::string writers_of(RecordType type) {
  std::string names;
  for (const Stage& stage : schedule) {
    if (((stage.writes | stage.changes) & mask_of(type)) != 0) names += (names.empty() ? "" : ", ") + code(stage.name);
  }
  if (type == RecordType::camera) return "the start of a flight";
  if (type == RecordType::event || type == RecordType::component || type == RecordType::timing) return "the executive";
  if (type == RecordType::start || type == RecordType::identity) return "the board's start-up";
  if (type == RecordType::checkpoint) return "every component, with its results";
  return names;
}

std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

const ReportInfo* report_of(RecordType type) {
  for (const ReportInfo& report : report_table()) {
    if (report.record == type) return &report;
  }
  return nullptr;
}

/// The fields with their places in the serial form, and in the housekeeping report where these differ.
std::string section(const RecordInfo& info) {
  std::string text = "\n## `" + std::string(info.name) + "`\n\n";
  text += sentence(info.description) + ". Type " + std::to_string(static_cast<unsigned>(info.type)) + ", " +
          std::to_string(serial_bytes(info)) + " bytes, by " + writers_of(info.type) + ".";
  const ReportInfo* const report = report_of(info.type);
  bool other_places = false;
  if (report != nullptr) {
    text += " SID " + std::to_string(report->id);
    text +=
        (report_bytes(*report) == serial_bytes(info) ? "" : ", " + std::to_string(report_bytes(*report)) + " octets") +
        ".";
    for (std::size_t f = 0; f + 1 < info.field_count; ++f) {
      other_places = other_places || (!is_reported(info.fields[f]) && is_reported(info.fields[f + 1]));
    }
  }
  Cells titles = {"offset", "field, type, unit", "meaning"};
  if (other_places) titles.insert(titles.begin() + 1, "octet");
  text += "\n\n" + table_head(titles);
  std::size_t offset = 0;
  std::size_t octet = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    Cells cells = {std::to_string(offset), declaration_cell(field), meaning_cell(field)};
    const std::size_t bytes = element_bytes(field.type) * field.count;
    if (other_places) cells.insert(cells.begin() + 1, is_reported(field) ? std::to_string(octet) : "");
    text += table_row(cells);
    offset += bytes;
    if (is_reported(field)) octet += bytes;
  }
  return text;
}

}  // namespace

std::string records_document() {
  std::string text =
      "Components exchange records, the store keeps them, and telemetry carries them. `fsw/records/records.inc` has "
      "the "
      "rows of which structs, SQL schema, serial form, housekeeping reports and this page are made. Schema version " +
      std::to_string(schema_version) +
      ".\n\n"
      "**Store.** A table per record, a column per field; `id` is the primary key. An array `a` takes the columns "
      "`a_0`, "
      "`a_1` and so on, a blob `b` of a record `r` the column `b_bytes` with its size and the table `r_b(id, data)`. "
      "Floating point is REAL, text TEXT, everything else INTEGER; NaN is NULL.\n\n"
      "**Serial form** (files of the link, [outbox](outbox.md)). The fields in this order, little-endian, without "
      "padding, at *offset* bytes. `text[n]` takes n bytes and ends at its first zero byte. A blob is written as its "
      "u32 size, and its bytes follow the record if the description of the carrier says so. An enumeration is a "
      "u8.\n\n"
      "**Housekeeping** by SID ([interface control document](interface-control-document.md#housekeeping-tm325)). The "
      "fields in this order, big-endian, without text and blobs, at *octet*, or at *offset* where there is no such "
      "column.\n\n"
      "**Meaning.** SI units and radians, beside the type; times in ns since the mission epoch. Ids count from 1, or "
      "are those of the named record; a field without a meaning has that of its name. A *sigma* is one standard "
      "deviation. An unknown value is NaN if the table names "
      "no other. Matrices are stored row by row, covariances as their lower triangles, rotations as unit quaternions "
      "w, "
      "x, y, z or as rotation vectors.\n\n"
      "**Frames.** Pixel (0,0) is the centre of the top-left pixel. Camera: x right, y down, z forward. World of a "
      "strip: right-handed, z up, origin at its first camera; a *strip unit* is the length of its first baseline, or "
      "one metre when an altitude was known (`pose.scale_source`).\n\n"
      "The blob `structure.points` is a sequence of points: f64[3] position, f32 error in px, u32 number of "
      "observations, and for each of these i64 keyframe and f32 x, y in px of the real image, little-endian, without "
      "padding.\n";
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    text += section(record_info(static_cast<RecordType>(t)));
  }
  return text;
}

}  // namespace ilp::docgen
