#include <sqlite3.h>

#include <stdexcept>
#include <utility>

#include "sim/ground/intake/catalogue_database.hpp"

namespace ilp::intake {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int file_version = 1;
constexpr const char* file_schema =
    "CREATE TABLE IF NOT EXISTS seen(name TEXT PRIMARY KEY, bytes INTEGER, modified INTEGER, fault TEXT) WITHOUT ROWID;"
    "CREATE TABLE IF NOT EXISTS file(name TEXT, crc32 INTEGER, bytes INTEGER, fault TEXT, contents BLOB, "
    "PRIMARY KEY(name, crc32));"
    "CREATE TABLE IF NOT EXISTS look(keyframe INTEGER PRIMARY KEY, digest INTEGER, bytes BLOB);"
    "CREATE TABLE IF NOT EXISTS result(digest INTEGER PRIMARY KEY, crc32 INTEGER, bytes BLOB);"
    "CREATE TABLE IF NOT EXISTS tile(strip INTEGER, \"row\" INTEGER, \"column\" INTEGER, digest INTEGER, summary BLOB, "
    "cells BLOB, PRIMARY KEY(strip, \"row\", \"column\"));"
    "CREATE TABLE IF NOT EXISTS finished_tile(strip INTEGER, \"row\" INTEGER, \"column\" INTEGER, digest INTEGER, "
    "summary BLOB, cells BLOB, PRIMARY KEY(strip, \"row\", \"column\"));";

[[noreturn]] void fail(sqlite3* database) {
  throw std::runtime_error(std::string("catalogue: ") + sqlite3_errmsg(database));
}

class SqliteStatement final : public Statement {
 public:
  SqliteStatement(sqlite3* database, const char* sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) fail(database);
  }
  ~SqliteStatement() override { sqlite3_finalize(statement_); }
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  Statement& bind(std::int64_t value) override {
    check(sqlite3_bind_int64(statement_, ++bound_, value));
    return *this;
  }
  Statement& bind(const std::string& text) override {
    check(sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
    return *this;
  }
  Statement& bind(std::span<const std::uint8_t> bytes) override {
    check(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC));
    return *this;
  }

  bool step() override {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail(database_);
    return code == SQLITE_ROW;
  }
  [[nodiscard]] std::int64_t integer(int column) override { return sqlite3_column_int64(statement_, column); }
  [[nodiscard]] Bytes bytes(int column) override {
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

void run_sql(sqlite3* database, const char* sql) {
  if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(database);
}

class SqliteDatabase final : public CatalogueDatabase {
 public:
  explicit SqliteDatabase(const std::filesystem::path& file) {
    sqlite3* opened = nullptr;
    const int code = sqlite3_open(file.c_str(), &opened);
    database_.reset(opened);
    if (code != SQLITE_OK) throw std::runtime_error("catalogue " + file.string() + ": " + sqlite3_errstr(code));
  }

  /// False when the file is damaged, or of another version.
  bool set_up(bool known_valid) {
    try {
      sqlite3_busy_timeout(database_.get(), 10000);
      // A power cut may cost the last steps, never the rest: they are computed again.
      exec("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA cache_size = -8192");
      const auto version = prepare("PRAGMA user_version");
      version->step();
      const std::int64_t found = version->integer(0);
      if (found != 0 && found != file_version) return false;
      if (!known_valid) {
        const auto check = prepare("PRAGMA quick_check(1)");
        if (!check->step() || check->text(0) != "ok") return false;
      }
      exec(file_schema);
      if (found == 0) exec(("PRAGMA user_version = " + std::to_string(file_version)).c_str());
      return true;
    } catch (const std::runtime_error&) {
      const int reason = sqlite3_errcode(database_.get());
      if (reason == SQLITE_CORRUPT || reason == SQLITE_NOTADB) return false;
      throw;
    }
  }

  std::unique_ptr<Statement> prepare(const std::string& sql, bool = false) override {
    return std::make_unique<SqliteStatement>(database_.get(), with_mission(sql, "", "", "").c_str());
  }
  void begin() override { exec("BEGIN IMMEDIATE"); }
  void commit() override { exec("COMMIT"); }
  void roll_back() noexcept override { sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr); }

 private:
  struct Closer {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
  };
  void exec(const char* sql) { run_sql(database_.get(), sql); }

  std::unique_ptr<sqlite3, Closer> database_;
};

}  // namespace

std::string with_mission(std::string sql, const std::string& condition, const std::string& key,
                         const std::string& value) {
  for (const auto& [token, text] :
       {std::pair<std::string, std::string>{"{and}", condition}, {"{key}", key}, {"{value}", value}}) {
    for (std::size_t at = sql.find(token); at != std::string::npos; at = sql.find(token, at + text.size())) {
      sql.replace(at, token.size(), text);
    }
  }
  return sql;
}

std::unique_ptr<CatalogueDatabase> open_catalogue_file(const std::filesystem::path& file, bool known_valid) {
  auto database = std::make_unique<SqliteDatabase>(file);
  if (!database->set_up(known_valid)) return nullptr;
  return database;
}

}  // namespace ilp::intake
