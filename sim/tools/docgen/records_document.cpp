#include "sim/tools/docgen/records_document.hpp"

#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"
#include "fsw/records/serial.hpp"
#include "hal/store/sql_columns.hpp"
#include "hal/store/sqlite/sql_text.hpp"
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

namespace {

/// Column names in the order of the schema that the store creates.
Cells columns_of(const RecordInfo& info) {
  SqlText sql;
  create_table(info, sql);
  const std::string text = sql.c_str();
  Cells columns;
  for (std::size_t at = text.find('('); at != std::string::npos; at = text.find(", ", at + 1)) {
    const std::size_t begin = text.find('"', at) + 1;
    columns.push_back(text.substr(begin, text.find('"', begin) - begin));
  }
  return columns;
}

std::string columns_cell(const RecordInfo& info, const FieldInfo& field, const Cells& columns, std::size_t first) {
  if (field.type == FieldType::blob) {
    FixedText<96> table;
    blob_table_name(info, field.name, table);
    return code(columns[first]) + ", table " + code(std::string(table.c_str()) + "(id, data)");
  }
  const std::size_t count = column_count(field);
  if (count == 1) return code(columns[first]);
  return code(columns[first]) + " to " + code(columns[first + count - 1]);
}

std::string type_cell(const FieldInfo& field) {
  std::string text = field_type_name(field.type);
  if (field.count > 1) text += "[" + std::to_string(field.count) + "]";
  return text;
}

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

std::string readers_of(RecordType type) {
  std::string names;
  for (const Stage& stage : schedule) {
    if ((stage.wakes & mask_of(type)) != 0) names += (names.empty() ? "" : ", ") + code(stage.name);
  }
  return names.empty() ? "no component" : names;
}

std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string section(const RecordInfo& info) {
  std::string text = "\n## `" + std::string(info.name) + "`\n\n";
  text += sentence(info.description) + ". Record type " + std::to_string(static_cast<unsigned>(info.type)) + ", " +
          std::to_string(serial_bytes(info)) + " bytes in serial form. Written by " + writers_of(info.type) +
          "; wakes " + readers_of(info.type) + ".\n\n";
  text += table_head({"offset", "field", "type", "unit", "SQL", "meaning"});
  const Cells columns = columns_of(info);
  std::size_t offset = 0;
  std::size_t column = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    text += table_row({std::to_string(offset), code(field.name), type_cell(field), cell(field.unit),
                       columns_cell(info, field, columns, column), meaning_cell(field)});
    offset += element_bytes(field.type) * field.count;
    column += column_count(field);
  }
  return text;
}

}  // namespace

std::string records_document() {
  std::string text =
      "Components exchange records, the store keeps them, and telemetry carries them. A record is a struct with a row "
      "per\nfield (`fsw/records/records.inc`). The structs, the SQL schema, the serial form, housekeeping "
      "reports and "
      "this page follow from the rows.\nSchema version " +
      std::to_string(schema_version) +
      ".\n\n"
      "**Store.** A table per record, a column per field. The first field, `id`, is the primary key. An array of n "
      "elements takes n columns.\nFloating point is REAL, text TEXT, everything else INTEGER; NaN is stored as NULL. "
      "A blob field is a column with its size and\na table of its own with its bytes.\n\n"
      "**Serial form** (files of the link, [outbox.md](outbox.md)). The fields in the order of the table, "
      "little-endian, without padding; the\ncolumn *offset* counts bytes from the start. `text[n]` takes n bytes and "
      "ends at its first zero byte. A blob is written as its u32 size.\nIts bytes follow the record if the description "
      "of the "
      "carrier says so. An enumeration is a u8; the column *meaning* lists its values.\n\n"
      "**Units and frames.** SI units and radians; times in ns since the mission epoch; px for pixels. Pixel (0,0) is "
      "the centre of the top-left\npixel. Camera: x right, y down, z forward. World of a strip: right-handed, z up, "
      "origin at its first camera; a *strip unit* is the length\nof its first baseline, or one metre when an altitude "
      "was known (`pose.scale_source`).\n\n"
      "The blob `structure.points` is a sequence of points. A point is f64[3] position, f32 error in px and u32 number "
      "of observations;\neach observation is i64 keyframe and f32 x, y in px of the real image. All are little-endian, "
      "without padding.\n";
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    text += section(record_info(static_cast<RecordType>(t)));
  }
  return text;
}

}  // namespace ilp::docgen
