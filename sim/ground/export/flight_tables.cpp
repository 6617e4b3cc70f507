#include "sim/ground/export/flight_tables.hpp"

#include <cstring>
#include <map>
#include <span>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::exports {
namespace {

constexpr double ns_per_s = 1e9;

std::string state_of(const intake::Keyframe& keyframe) {
  if (!keyframe.pose) return "no pose received";
  switch (keyframe.pose->state) {
    case PoseState::final:
      return "posed";
    case PoseState::provisional:
    case PoseState::trial:
    case PoseState::trial_failed:
      return "provisional pose only";
    case PoseState::failed:
      return std::string("no pose: ") + words_of(keyframe.pose->verdict);
    case PoseState::count:
      break;
  }
  return "unknown state";
}

std::string products_of(const intake::Keyframe& keyframe) {
  std::string names;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    if (keyframe.product(kind)) names += (names.empty() ? "" : " ") + std::string(name_of(kind));
  }
  return names;
}

Cell bytes_of(const intake::Keyframe& keyframe, ProductKind kind) {
  const std::optional<intake::ProductAccount>& product = keyframe.product(kind);
  return product ? Cell(static_cast<std::int64_t>(product->bytes)) : Cell();
}

template <typename T>
T value_at(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof(value));
  return value;
}

Cell cell_at(FieldType type, const unsigned char* at, std::size_t capacity) {
  switch (type) {
    case FieldType::u8:
      return std::int64_t{*at};
    case FieldType::u16:
      return std::int64_t{value_at<std::uint16_t>(at)};
    case FieldType::u32:
      return std::int64_t{value_at<std::uint32_t>(at)};
    case FieldType::i32:
      return std::int64_t{value_at<std::int32_t>(at)};
    case FieldType::i64:
      return value_at<std::int64_t>(at);
    case FieldType::f32:
      return double{value_at<float>(at)};
    case FieldType::f64:
      return value_at<double>(at);
    case FieldType::text:
      return std::string(reinterpret_cast<const char*>(at), strnlen(reinterpret_cast<const char*>(at), capacity));
    case FieldType::blob:
      break;
  }
  return {};
}

ColumnType column_type(FieldType type) {
  if (type == FieldType::text) return ColumnType::text;
  return type == FieldType::f32 || type == FieldType::f64 ? ColumnType::real : ColumnType::integer;
}

// An array is a column per element; the bytes of blobs are not here.
template <typename Visit>
void for_each_column(const RecordInfo& info, const Visit& visit) {
  for (const FieldInfo& field : std::span(info.fields, info.field_count)) {
    if (field.type == FieldType::blob) continue;
    const bool array = field.type != FieldType::text && field.count > 1;
    for (std::size_t i = 0; i < (array ? field.count : 1U); ++i) {
      visit(field, field.name + (array ? "_" + std::to_string(i) : std::string()),
            field.offset + i * element_bytes(field.type));
    }
  }
}

template <typename Record>
Table record_table(std::span<const Record> records) {
  const RecordInfo& info = record_info<Record>();
  Table table;
  for_each_column(info, [&](const FieldInfo& field, const std::string& name, std::size_t) {
    table.columns.push_back({name, column_type(field.type)});
  });
  for (const Record& record : records) {
    std::vector<Cell>& row = table.rows.emplace_back();
    const auto* bytes = reinterpret_cast<const unsigned char*>(&record);
    for_each_column(info, [&](const FieldInfo& field, const std::string&, std::size_t offset) {
      row.push_back(cell_at(field.type, bytes + offset, field.count));
    });
  }
  return table;
}

template <typename Record>
std::span<const Record> all_of(const std::optional<Record>& record) {
  return record ? std::span(&*record, 1) : std::span<const Record>();
}

Table navigation_table(const intake::Flight& flight) {
  std::vector<NavigationRecord> records;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.navigation) records.push_back(*keyframe.navigation);
  }
  return record_table(std::span<const NavigationRecord>(records));
}

Table strip_frame_table(const intake::Flight& flight) {
  std::vector<StripFrameRecord> records;
  for (const auto& [id, strip] : flight.strips) {
    if (strip.frame) records.push_back(*strip.frame);
  }
  return record_table(std::span<const StripFrameRecord>(records));
}

}  // namespace

std::vector<Column> keyframe_columns() {
  using enum ColumnType;
  return {{"keyframe", integer},    {"strip", integer},      {"frame", integer},   {"name", text},
          {"time_s", real},         {"state", text},         {"sigma_x", real},    {"sigma_y", real},
          {"sigma_z", real},        {"rms_px", real},        {"overlap", real},    {"depth", text},
          {"richness", real},       {"novelty", real},       {"newly_seen", real}, {"products", text},
          {"image_bytes", integer}, {"depth_bytes", integer}};
}

std::vector<Cell> keyframe_row(const intake::Keyframe& k, double unit_length) {
  std::vector<Cell> row(keyframe_columns().size());
  row[0] = k.id;
  row[1] = k.strip_id;
  row[3] = k.name;
  row[5] = state_of(k);
  if (k.record) {
    row[2] = k.record->frame_id;
    row[4] = static_cast<double>(k.record->time_ns) / ns_per_s;
    // The first keyframe of a strip overlaps with none.
    if (k.record->index > 0) row[10] = k.record->overlap;
  }
  if (k.posed()) {
    for (std::size_t i = 0; i < 3; ++i) row[6 + i] = unit_length * k.pose->sigma[i];
    row[9] = k.pose->rms_px;
  }
  if (k.depth) {
    row[11] = std::string(words_of(k.depth->verdict));
  }
  const double pixels = static_cast<double>(k.camera.width) * k.camera.height;
  if (k.mask_record && pixels > 0) row[14] = k.mask_record->newly_seen / pixels;
  if (k.richness) {
    row[12] = k.richness->richness;
    row[13] = k.richness->novelty;
  }
  row[15] = products_of(k);
  row[16] = bytes_of(k, ProductKind::image);
  row[17] = bytes_of(k, ProductKind::depth);
  return row;
}

Table keyframe_table(const intake::Flight& flight, const std::map<std::int64_t, map::Balance>& balance) {
  Table table;
  table.columns = keyframe_columns();
  using enum ColumnType;
  for (const char* name : {"x", "y", "z", "q_w", "q_x", "q_y", "q_z"}) table.columns.push_back({name, real});
  table.columns.push_back({"unit", text});
  const std::size_t radiometry = table.columns.size();
  for (const char* name : {"ortho_gain", "ortho_offset"}) table.columns.push_back({name, real});
  std::map<std::int64_t, std::string> units;  // of strips: a strip's is looked for in all its keyframes
  for (const auto& [id, strip] : flight.strips) units[id] = intake::unit_of(flight, strip);
  for (const auto& [id, keyframe] : flight.keyframes) {
    std::vector<Cell> row = keyframe_row(keyframe, 1);
    row.resize(table.columns.size());
    if (keyframe.posed()) {
      std::size_t at = keyframe_columns().size();
      for (const double c : keyframe.pose->centre) row[at++] = c;
      for (const double q : keyframe.pose->q_cam_from_world) row[at++] = q;
      const auto unit = units.find(keyframe.strip_id);
      if (unit != units.end()) row[at] = unit->second;
    }
    if (const auto shown = balance.find(id); shown != balance.end()) {
      row[radiometry] = shown->second.gain;
      row[radiometry + 1] = shown->second.offset;
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table event_table(const intake::Flight& flight) {
  using enum ColumnType;
  Table table;
  table.columns = {{"event", integer}, {"time_s", real},  {"component", text}, {"name", text},
                   {"severity", text}, {"meaning", text}, {"advice", text},    {"place", text}};
  for (const EventRecord& event : flight.events) {
    table.rows.push_back({event.id, static_cast<double>(event.time_ns) / 1e9,
                          std::string(event.component, strnlen(event.component, sizeof(event.component))),
                          host::event_name(event.code), std::string(host::severity_name(event.severity)),
                          host::event_sentence(event), host::event_advice(event.code),
                          std::string(event.place, strnlen(event.place, sizeof(event.place)))});
  }
  return table;
}

std::vector<std::string> write_flight_tables(const intake::Flight& flight,
                                             const std::map<std::int64_t, map::Balance>& balance,
                                             const std::filesystem::path& folder) {
  const std::pair<const char*, Table> tables[] = {
      {"keyframes.csv", keyframe_table(flight, balance)},
      {"events.csv", event_table(flight)},
      {"navigation.csv", navigation_table(flight)},
      {"strip-frames.csv", strip_frame_table(flight)},
      {"housekeeping-components.csv", record_table(std::span<const ComponentRecord>(flight.components))},
      {"housekeeping-storage.csv", record_table(all_of(flight.storage))},
      {"housekeeping-timing.csv", record_table(all_of(flight.timing))}};
  std::vector<std::string> names;
  for (const auto& [name, table] : tables) {
    const bool of_every_flight = std::string_view(name) == "keyframes.csv" || std::string_view(name) == "events.csv";
    std::error_code ignored;
    if (!of_every_flight && table.rows.empty()) {
      std::filesystem::remove(folder / name, ignored);
      continue;
    }
    write_csv(table, folder / name);
    names.emplace_back(name);
  }
  return names;
}

}  // namespace ilp::exports
