#include "sim/ground/intake/flight_info.hpp"

#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/host/files.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::intake {
namespace {

constexpr RecordType kinds[] = {RecordType::camera,     RecordType::frame,       RecordType::overlap,
                                RecordType::strip,      RecordType::keyframe,    RecordType::pose,
                                RecordType::depth,      RecordType::richness,    RecordType::product,
                                RecordType::event,      RecordType::component,   RecordType::storage,
                                RecordType::capture,    RecordType::calibration, RecordType::calibration_check,
                                RecordType::navigation, RecordType::strip_frame, RecordType::mask};

}  // namespace

FlightInfo read_flight_info(const std::filesystem::path& path) {
  const nlohmann::json json = nlohmann::json::parse(host::read_file(path), nullptr, false);
  if (!json.is_object()) throw std::runtime_error(path.string() + " is not a JSON object");
  const auto number = [&json](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
  };
  const auto text = [&json](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  FlightInfo info;
  info.wall_s = number("wall_s");
  info.cpu_s = number("cpu_s");
  info.flight_cpu_s = number("flight_software_cpu_s");
  info.peak_rss_mib = number("peak_rss_mib");
  info.static_bytes = number("static_bytes");
  info.frames = number("frames");
  info.keyframes = number("keyframes");
  info.seed = number("seed");
  info.binning = number("binning");
  info.target_overlap = number("target_overlap");
  info.profile = text("profile");
  info.software = text("software");
  info.source = text("source");
  const auto notes = json.find("notes");
  if (notes != json.end() && notes->is_array()) {
    for (const nlohmann::json& note : *notes) {
      if (note.is_string()) info.notes.push_back(note.get<std::string>());
    }
  }
  return info;
}

std::vector<RecordEntry> read_flight_database(const std::filesystem::path& database) {
  const auto store = std::make_unique<SqliteStore>();
  host::require(store->open_read_only(database.c_str()), "flight database " + database.string());
  std::vector<RecordEntry> entries;
  for (const RecordType type : kinds) {
    const RecordInfo& info = record_info(type);
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    std::int64_t id = 0;
    Status found;
    for (found = store->next(info, id, record); found.ok(); found = store->next(info, id, record)) {
      id = id_of(record);
      drop_blobs(info, record);
      RecordEntry entry{type, std::vector<std::uint8_t>(serial_bytes(info)), {}};
      host::require(serialize(info, record, entry.serial), "flight database " + database.string());
      for_each_blob(info, [&](const FieldInfo&, std::size_t) { entry.blobs.emplace_back(); });
      entries.push_back(std::move(entry));
    }
    if (!found.is(StatusCode::not_found)) host::require(found, "flight database " + database.string());
  }
  return entries;
}

std::optional<double> read_setting(const std::filesystem::path& database, const std::string& name) {
  const auto store = std::make_unique<SqliteStore>();
  host::require(store->open_read_only(database.c_str()), "flight database " + database.string());
  SettingRecord setting;
  Status found;
  for (found = next(*store, 0, setting); found.ok(); found = next(*store, setting.id, setting)) {
    if (name == setting.name) return setting.value;
  }
  if (!found.is(StatusCode::not_found)) host::require(found, "flight database " + database.string());
  return std::nullopt;
}

}  // namespace ilp::intake
