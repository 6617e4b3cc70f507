#include "sim/ground/intake/flight_database.hpp"

#include <cstring>
#include <memory>
#include <stdexcept>

#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::intake {
namespace {

constexpr RecordType kinds[] = {RecordType::camera,  RecordType::frame,       RecordType::overlap,
                                RecordType::strip,   RecordType::keyframe,    RecordType::pose,
                                RecordType::depth,   RecordType::richness,    RecordType::product,
                                RecordType::event,   RecordType::component,   RecordType::storage,
                                RecordType::capture, RecordType::calibration, RecordType::calibration_check};

}  // namespace

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

}  // namespace ilp::intake
