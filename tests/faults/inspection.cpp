#include "tests/faults/inspection.hpp"

#include <sqlite3.h>

#include <cstring>
#include <new>
#include <stdexcept>
#include <vector>

#include "fsw/base/checksum.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/faults/tiny_flight.hpp"
#include "tests/faults/trial.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

fs::path copy_of(const fs::path& folder, const char* name) {
  const fs::path copy = folder / name;
  fs::remove_all(copy);
  fs::create_directories(copy);
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (entry.is_regular_file() && file.rfind("flight.db", 0) == 0 && !file.ends_with("-reserve"))
      fs::copy(entry.path(), copy / file);
  }
  return copy / "flight.db";
}

bool integrity_is_ok(const fs::path& database, const char* vfs) {
  sqlite3* db = nullptr;
  sqlite3_stmt* statement = nullptr;
  const bool ok = sqlite3_open_v2(database.c_str(), &db, SQLITE_OPEN_READWRITE, vfs) == SQLITE_OK &&
                  sqlite3_prepare_v2(db, "PRAGMA integrity_check", -1, &statement, nullptr) == SQLITE_OK &&
                  sqlite3_step(statement) == SQLITE_ROW &&
                  std::strcmp(reinterpret_cast<const char*>(sqlite3_column_text(statement, 0)), "ok") == 0;
  sqlite3_finalize(statement);
  sqlite3_close(db);
  return ok;
}

/// False if anything could not be read.
bool read_all(Store& store, std::uint64_t& content) {
  bool whole = true;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    alignas(8) std::byte record[limits::max_record_bytes]{};
    Status status;
    for (std::int64_t id = std::numeric_limits<std::int64_t>::min();;) {
      status = store.next(info, id, record);
      if (status.is(StatusCode::record_damaged)) {
        whole = false;
        id = status.a;
        continue;
      }
      if (!status.ok()) break;
      id = id_of(record);
      for (std::size_t f = 0; f < info.field_count; ++f) {
        const FieldInfo& field = info.fields[f];
        content = checksum64({record + field.offset, element_bytes(field.type) * field.count}, content);
        std::vector<std::uint8_t> bytes(field.type == FieldType::blob ? blob_bytes(record, field) : 0);
        if (bytes.empty()) continue;
        if (!store.read_blob(info, field.name, id, 0, bytes).ok()) whole = false;
        content = checksum64(std::as_bytes(std::span(bytes)), content);
      }
    }
    whole = whole && status.is(StatusCode::not_found);
  }
  return whole;
}

}  // namespace

Inspection inspect(const fs::path& folder, const CommitLedger* ledger) {
  auto& seen = *new (share(sizeof(Inspection))) Inspection;
  int status = 0;
  const auto look = [&] {
    SqliteStore store;
    const bool ok = register_checked_vfs() == SQLITE_OK && integrity_is_ok(copy_of(folder, "look"), "unix") &&
                    integrity_is_ok(copy_of(folder, "look"), checked_vfs);
    constexpr std::int64_t cache_kib = 1024;
    if (!sqlite::open_damaged(store.session(), copy_of(folder, "look").c_str(), cache_kib).ok()) return 0;
    seen.valid = read_all(store, seen.content) && ok;
    if (ledger != nullptr) seen.missing = ledger->missing(store, seen.missing_type, seen.missing_id);
    return 0;
  };
  const auto start = [&] {
    MissionParameters mission = *static_memory().mission;
    seen.start = static_memory().store->open(copy_of(folder, "look").c_str(), StoreTrouble::refuse, mission);
    return 0;
  };
  seen.done = run_apart(look, status) && status == 0 && run_apart(start, status) && status == 0;
  const Inspection result = seen;
  unshare(&seen, sizeof(seen));
  fs::remove_all(folder / "look");
  return result;
}

}  // namespace ilp::faults
