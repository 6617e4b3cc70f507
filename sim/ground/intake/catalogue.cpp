#include "sim/ground/intake/catalogue.hpp"

#include <sqlite3.h>

#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "fsw/base/crc.hpp"
#include "sim/host/files.hpp"

namespace ilp::intake {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

constexpr int catalogue_version = 1;
constexpr const char* schema =
    "CREATE TABLE IF NOT EXISTS seen(name TEXT PRIMARY KEY, bytes INTEGER, modified INTEGER, fault TEXT) WITHOUT ROWID;"
    "CREATE TABLE IF NOT EXISTS file(name TEXT, crc32 INTEGER, bytes INTEGER, fault TEXT, contents BLOB, "
    "PRIMARY KEY(name, crc32));"
    "CREATE TABLE IF NOT EXISTS look(keyframe INTEGER PRIMARY KEY, digest INTEGER, bytes BLOB);"
    "CREATE TABLE IF NOT EXISTS result(digest INTEGER PRIMARY KEY, crc32 INTEGER, bytes BLOB);"
    "CREATE TABLE IF NOT EXISTS tile(strip INTEGER, row INTEGER, column INTEGER, digest INTEGER, summary BLOB, "
    "cells BLOB, PRIMARY KEY(strip, row, column));"
    "CREATE TABLE IF NOT EXISTS finished_tile(strip INTEGER, row INTEGER, column INTEGER, digest INTEGER, "
    "summary BLOB, cells BLOB, PRIMARY KEY(strip, row, column));";

/// Versions of one file that are kept; a link that damages files does not fill the disk.
constexpr std::int64_t max_versions = 4;

const char* table_of(TileStage stage) {
  return stage == TileStage::painted ? "tile" : "finished_tile";
}

[[noreturn]] void fail(sqlite3* database) {
  throw std::runtime_error(std::string("catalogue: ") + sqlite3_errmsg(database));
}

class Statement {
 public:
  Statement(sqlite3* database, const char* sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) fail(database);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(std::int64_t value) {
    check(sqlite3_bind_int64(statement_, ++bound_, value));
    return *this;
  }
  Statement& bind(const std::string& text) {
    check(sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
    return *this;
  }
  /// The bytes must live until the statement has run.
  Statement& bind(std::span<const std::uint8_t> bytes) {
    check(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC));
    return *this;
  }

  /// True while there is a row.
  bool step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail(database_);
    return code == SQLITE_ROW;
  }
  void run() {
    while (step()) {
    }
  }
  [[nodiscard]] std::int64_t integer(int column) { return sqlite3_column_int64(statement_, column); }
  [[nodiscard]] std::string text(int column) {
    const Bytes octets = bytes(column);
    return {octets.begin(), octets.end()};
  }
  [[nodiscard]] Bytes bytes(int column) {
    const auto* first = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_, column));
    const int size = sqlite3_column_bytes(statement_, column);
    return first == nullptr ? Bytes() : Bytes(first, first + size);
  }

 private:
  void check(int code) {
    if (code != SQLITE_OK) fail(database_);
  }
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

void run(sqlite3* database, const char* sql) {
  if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(database);
}

/// Rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(sqlite3* database) : database_(database) { run(database_, "BEGIN IMMEDIATE"); }
  ~Transaction() {
    if (database_ != nullptr) sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    run(database_, "COMMIT");
    database_ = nullptr;
  }

 private:
  sqlite3* database_;
};

std::int64_t modified_at(const fs::path& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  return error ? 0 : static_cast<std::int64_t>(time.time_since_epoch().count());
}

// SQLite's integers are signed.
std::int64_t signed_of(std::uint64_t digest) {
  return static_cast<std::int64_t>(digest);
}

std::string fault_of(const fs::path& path, std::int64_t size, Bytes& contents) {
  try {
    if (static_cast<std::uintmax_t>(size) > max_file_bytes)
      throw BadFile("larger than any file of the flight software");
    contents = host::read_file(path);
    check_file(path.filename().string(), contents);
    return "";
  } catch (const std::exception& fault) {
    return fault.what();
  }
}

}  // namespace

void Catalogue::Closer::operator()(sqlite3* database) const {
  sqlite3_close(database);
}

Catalogue::~Catalogue() = default;

bool Catalogue::open(const fs::path& file, bool known_sound) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open(file.c_str(), &opened);
  database_.reset(opened);
  if (code != SQLITE_OK) throw std::runtime_error("catalogue " + file.string() + ": " + sqlite3_errstr(code));
  try {
    sqlite3_busy_timeout(opened, 10000);
    // A power cut may cost the last steps, never the rest: they are computed again.
    run(opened, "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA cache_size = -8192");
    Statement version(opened, "PRAGMA user_version");
    version.step();
    const std::int64_t found = version.integer(0);
    if (found != 0 && found != catalogue_version) return false;
    if (!known_sound) {
      Statement check(opened, "PRAGMA quick_check(1)");
      if (!check.step() || check.text(0) != "ok") return false;
    }
    run(opened, schema);
    if (found == 0) run(opened, ("PRAGMA user_version = " + std::to_string(catalogue_version)).c_str());
    return true;
  } catch (const std::runtime_error&) {
    const int reason = sqlite3_errcode(opened);
    if (reason == SQLITE_CORRUPT || reason == SQLITE_NOTADB) return false;
    throw;
  }
}

Catalogue::Catalogue(const fs::path& file, bool known_sound) : folder_(fs::absolute(file).parent_path()) {
  if (open(file, known_sound)) return;
  database_.reset();
  set_aside_ = true;
  for (const char* part : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    fs::rename(file.string() + part, file.string() + ".damaged" + part, ignored);
  }
  if (!open(file, false)) throw std::runtime_error("catalogue " + file.string() + ": cannot be started over");
}

bool Catalogue::is_seen(const std::string& name, std::int64_t bytes, std::int64_t modified) {
  Statement seen(database_.get(), "SELECT 1 FROM seen WHERE name = ? AND bytes = ? AND modified = ?");
  return seen.bind(name).bind(bytes).bind(modified).step();
}

/// Only a file that comes under a name that is already held can show that it belongs to another flight.
void Catalogue::refuse_another_flight(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths) {
    const std::string name = path.filename().string();
    std::error_code error;
    const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
    if (!name.ends_with(".ilp") || error || is_seen(name, size, modified_at(path))) continue;
    Statement held(database_.get(), "SELECT contents FROM file WHERE name = ? AND fault = '' ORDER BY rowid LIMIT 1");
    Bytes contents;
    if (!held.bind(name).step() || !fault_of(path, size, contents).empty()) continue;
    const std::vector<RecordFile> both{{0, parse_record_file(held.bytes(0))}, {1, parse_record_file(contents)}};
    if (files_of_other_flights(both).empty()) continue;
    throw std::runtime_error("the results are of another flight than " + path.string() +
                             ": choose another folder for them, or begin afresh (--afresh)");
  }
}

void Catalogue::take_file(const fs::path& path, std::int64_t bytes, std::int64_t modified, Intake& intake) {
  sqlite3* database = database_.get();
  const std::string name = path.filename().string();
  if (is_seen(name, bytes, modified)) return;
  ++intake.fresh;
  Bytes contents;
  const std::string fault = fault_of(path, bytes, contents);
  Statement(database, "INSERT OR REPLACE INTO seen VALUES(?, ?, ?, ?)")
      .bind(name)
      .bind(bytes)
      .bind(modified)
      .bind(fault)
      .run();
  if (!fault.empty()) return;
  Statement versions(database, "SELECT count(*) FROM file WHERE name = ? AND fault = ''");
  versions.bind(name).step();
  if (versions.integer(0) >= max_versions) return;
  Statement(database, "INSERT OR IGNORE INTO file VALUES(?, ?, ?, '', ?)")
      .bind(name)
      .bind(std::int64_t{crc32(contents)})
      .bind(bytes)
      .bind(std::span<const std::uint8_t>(contents))
      .run();
}

Catalogue::Intake Catalogue::take_in(const fs::path& folder,
                                     const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::lock_guard lock(mutex_);
  const std::vector<fs::path> paths = files_of(folder);
  refuse_another_flight(paths);
  Intake intake;
  intake.files = paths.size();
  constexpr std::size_t files_at_once = 64;
  for (std::size_t begin = 0; begin < paths.size(); begin += files_at_once) {
    const std::size_t end = std::min(begin + files_at_once, paths.size());
    Transaction transaction(database_.get());
    for (std::size_t i = begin; i < end; ++i) {
      std::error_code error;
      const auto size = fs::file_size(paths[i], error);
      if (!error) take_file(paths[i], static_cast<std::int64_t>(size), modified_at(paths[i]), intake);
    }
    transaction.commit();
    if (progress) progress(end, paths.size());
  }
  return intake;
}

Outbox Catalogue::outbox() {
  const std::lock_guard lock(mutex_);
  OutboxBuilder builder(std::make_shared<Spool>(folder_));
  Statement held(database_.get(),
                 "SELECT name, contents, crc32 FROM file WHERE fault = '' ORDER BY name, bytes, crc32");
  std::vector<std::pair<std::string, std::int64_t>> damaged;
  while (held.step()) {
    Bytes contents = held.bytes(1);
    if (std::int64_t{crc32(contents)} == held.integer(2)) {
      builder.add(held.text(0), std::move(contents));
    } else {
      damaged.emplace_back(held.text(0), held.integer(2));
    }
  }
  for (const auto& [name, crc] : damaged) {
    forget_file(name, crc);
    ReceivedFile file;
    file.name = name;
    file.fault = "damaged in the catalogue: it is taken in again where it is still there";
    builder.add_fault(std::move(file));
  }
  // What was seen and is not held, unless another version of it is.
  Statement faulty(database_.get(),
                   "SELECT name, bytes, fault FROM seen WHERE fault <> '' AND NOT EXISTS "
                   "(SELECT 1 FROM file WHERE file.name = seen.name AND file.fault = '') UNION "
                   "SELECT name, bytes, fault FROM file WHERE fault <> '' ORDER BY name");
  while (faulty.step()) {
    ReceivedFile file;
    file.name = faulty.text(0);
    file.bytes = static_cast<std::uint64_t>(faulty.integer(1));
    file.fault = faulty.text(2);
    builder.add_fault(std::move(file));
  }
  return builder.finish();
}

/// As if it had never come.
void Catalogue::forget_file(const std::string& name, std::int64_t crc) {
  Transaction transaction(database_.get());
  Statement(database_.get(), "DELETE FROM file WHERE name = ? AND crc32 = ?").bind(name).bind(crc).run();
  Statement(database_.get(), "DELETE FROM seen WHERE name = ?").bind(name).run();
  transaction.commit();
}

void Catalogue::reject(const ReceivedFile& file) {
  const std::lock_guard lock(mutex_);
  Statement(database_.get(), "UPDATE file SET fault = ?, contents = NULL WHERE name = ? AND crc32 = ?")
      .bind(file.fault)
      .bind(file.name)
      .bind(std::int64_t{file.crc32})
      .run();
}

std::optional<Bytes> Catalogue::look(std::int64_t keyframe_id, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  Statement found(database_.get(), "SELECT bytes FROM look WHERE keyframe = ? AND digest = ?");
  return found.bind(keyframe_id).bind(signed_of(digest)).step() ? std::optional(found.bytes(0)) : std::nullopt;
}

void Catalogue::put_look(std::int64_t keyframe_id, std::uint64_t digest, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  Statement(database_.get(), "INSERT OR REPLACE INTO look VALUES(?, ?, ?)")
      .bind(keyframe_id)
      .bind(signed_of(digest))
      .bind(std::span<const std::uint8_t>(bytes))
      .run();
}

std::optional<Bytes> Catalogue::result(std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  Statement found(database_.get(), "SELECT crc32, bytes FROM result WHERE digest = ?");
  if (!found.bind(signed_of(digest)).step()) return std::nullopt;
  Bytes bytes = found.bytes(1);
  if (found.integer(0) != std::int64_t{crc32(bytes)}) return std::nullopt;
  results_used_.insert(signed_of(digest));
  return bytes;
}

void Catalogue::put_result(std::uint64_t digest, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  results_used_.insert(signed_of(digest));
  Statement(database_.get(), "INSERT OR REPLACE INTO result VALUES(?, ?, ?)")
      .bind(signed_of(digest))
      .bind(std::int64_t{crc32(bytes)})
      .bind(std::span<const std::uint8_t>(bytes))
      .run();
}

void Catalogue::forget_other_results() {
  const std::lock_guard lock(mutex_);
  std::vector<std::int64_t> others;
  Statement all(database_.get(), "SELECT digest FROM result");
  while (all.step()) {
    if (!results_used_.contains(all.integer(0))) others.push_back(all.integer(0));
  }
  for (const std::int64_t digest : others)
    Statement(database_.get(), "DELETE FROM result WHERE digest = ?").bind(digest).run();
}

std::optional<Bytes> Catalogue::tile_part(const char* column, const TileKey& key, std::uint64_t digest) {
  Statement found(database_.get(), (std::string("SELECT ") + column + " FROM " + table_of(key.stage) +
                                    " WHERE strip = ? AND row = ? AND column = ? AND digest = ?")
                                       .c_str());
  found.bind(key.strip_id).bind(key.place.row).bind(key.place.column).bind(signed_of(digest));
  return found.step() ? std::optional(found.bytes(0)) : std::nullopt;
}

std::optional<Bytes> Catalogue::summary(const TileKey& key, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  return tile_part("summary", key, digest);
}

std::optional<Bytes> Catalogue::cells(const TileKey& key, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  return tile_part("cells", key, digest);
}

void Catalogue::put(const TileKey& key, std::uint64_t digest, Bytes summary, Bytes cells) {
  const std::lock_guard lock(mutex_);
  Statement(database_.get(),
            (std::string("INSERT OR REPLACE INTO ") + table_of(key.stage) + " VALUES(?, ?, ?, ?, ?, ?)").c_str())
      .bind(key.strip_id)
      .bind(key.place.row)
      .bind(key.place.column)
      .bind(signed_of(digest))
      .bind(std::span<const std::uint8_t>(summary))
      .bind(std::span<const std::uint8_t>(cells))
      .run();
}

}  // namespace ilp::intake
