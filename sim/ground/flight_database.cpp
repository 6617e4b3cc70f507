#include "sim/ground/flight_database.hpp"

#include <cstring>
#include <memory>
#include <stdexcept>

#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/io/status_error.hpp"

namespace ilp::ground {
namespace {

constexpr RecordType kinds[] = {RecordType::camera,  RecordType::frame,       RecordType::overlap,
                                RecordType::strip,   RecordType::keyframe,    RecordType::pose,
                                RecordType::depth,   RecordType::richness,    RecordType::product,
                                RecordType::event,   RecordType::component,   RecordType::storage,
                                RecordType::capture, RecordType::calibration, RecordType::calibration_check};

void drop_blobs(const RecordInfo& info, std::uint8_t* record) {
  for (std::size_t f = 0; f < info.field_count; ++f) {
    if (info.fields[f].type == FieldType::blob) std::memset(record + info.fields[f].offset, 0, sizeof(Blob));
  }
}

}  // namespace

std::vector<RecordEntry> read_flight_database(const std::filesystem::path& database) {
  const auto store = std::make_unique<SqliteStore>();
  sim::require(store->open_read_only(database.c_str()), "flight database " + database.string());
  std::vector<RecordEntry> entries;
  for (const RecordType type : kinds) {
    const RecordInfo& info = record_info(type);
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    std::int64_t id = 0;
    Status found;
    for (found = store->next(info, id, record); found.ok(); found = store->next(info, id, record)) {
      std::memcpy(&id, record, sizeof(id));
      drop_blobs(info, record);
      RecordEntry entry{type, std::vector<std::uint8_t>(serial_bytes(info)), {}};
      sim::require(serialize(info, record, entry.serial), "flight database " + database.string());
      for (std::size_t f = 0; f < info.field_count; ++f) {
        if (info.fields[f].type == FieldType::blob) entry.blobs.emplace_back();
      }
      entries.push_back(std::move(entry));
    }
    if (!found.is(StatusCode::not_found)) sim::require(found, "flight database " + database.string());
  }
  return entries;
}

}  // namespace ilp::ground
