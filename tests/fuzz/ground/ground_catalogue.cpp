// The ground's catalogue. A database file that is damaged anywhere ends in words for the user or is quarantined; rows
// that hold anything at all do no more harm.
#include <sqlite3.h>

#include <array>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "fsw/base/crc.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/files.hpp"
#include "tests/fuzz/ground/known_outbox.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::fuzz {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

/// A catalogue that holds the known outbox, as a database file.
const KnownFile& known_catalogue() {
  static const KnownFile file = [] {
    const test::TemporaryFolder folder;
    const fs::path outbox = folder.path() / "outbox", path = folder.path() / "catalogue.db";
    fs::create_directories(outbox);
    for (const KnownFile& known : known_outbox()) host::write_file(outbox / known.name, known.bytes);
    {
      intake::Catalogue catalogue(path);
      static_cast<void>(catalogue.take_in(outbox));
    }
    return KnownFile{"catalogue.db", host::read_file(path)};
  }();
  return file;
}

/// Everything that the ground does with a catalogue, as far as `what` wants it.
void use(intake::Catalogue& catalogue, const fs::path& outbox, std::uint8_t what) {
  if ((what & 1U) == 0) static_cast<void>(catalogue.take_in(outbox));
  if ((what & 2U) == 0) {
    intake::Outbox held = catalogue.outbox();
    static_cast<void>(intake::index_flight(held));
  }
  if ((what & 4U) == 0) {
    static_cast<void>(catalogue.quick_look(1, 1));
    catalogue.put_quick_look(1, 1, Bytes(10));
  }
  if ((what & 8U) == 0) {
    static_cast<void>(catalogue.summary({1, {0, 0}}, 1));
    catalogue.put({1, {0, 0}}, 1, Bytes(10), Bytes(10));
  }
}

/// A catalogue that stays open, and a second connection that writes into it what no catalogue writes.
class OpenCatalogue {
 public:
  OpenCatalogue() {
    fs::create_directories(outbox());
    for (const KnownFile& known : known_outbox()) {
      if (!known.name.ends_with(".jp2")) host::write_file(outbox() / known.name, known.bytes);
    }
    catalogue_ = std::make_unique<intake::Catalogue>(folder_.path() / "catalogue.db");
    static_cast<void>(catalogue_->take_in(outbox()));
    catalogue_->put_quick_look(1, 1, Bytes(100, 7));
    catalogue_->put({1, {0, 0}}, 1, Bytes(100, 7), Bytes(100, 7));
    require(sqlite3_open((folder_.path() / "catalogue.db").c_str(), &writer_) == SQLITE_OK, "a second connection");
    for (std::size_t i = 0; i < std::size(tables); ++i) {
      const std::string table = tables[i];
      run("CREATE TEMP TABLE known_" + table + " AS SELECT * FROM main." + table);
      empty_[i] = prepared("DELETE FROM main." + table);
      fill_[i] = prepared("INSERT INTO main." + table + " SELECT * FROM known_" + table);
    }
  }
  ~OpenCatalogue() {
    for (sqlite3_stmt* statement : empty_) sqlite3_finalize(statement);
    for (sqlite3_stmt* statement : fill_) sqlite3_finalize(statement);
    sqlite3_close(writer_);
  }
  OpenCatalogue(const OpenCatalogue&) = delete;
  OpenCatalogue& operator=(const OpenCatalogue&) = delete;

  [[nodiscard]] fs::path outbox() const { return folder_.path() / "outbox"; }
  [[nodiscard]] intake::Catalogue& catalogue() { return *catalogue_; }

  /// Puts right what the last input and its use have changed, before it changes what this one says.
  void change(Choices& choices, std::uint8_t what) {
    run("BEGIN");
    for (std::size_t i = 0; i < std::size(tables); ++i) {
      if (!changed_[i]) continue;
      run(empty_[i]);
      run(fill_[i]);
    }
    changed_ = {(what & 1U) == 0, (what & 1U) == 0, (what & 4U) == 0, (what & 8U) == 0};
    for (int i = 0; i < 8 && !choices.empty(); ++i) change_cell(choices);
    run("COMMIT");
  }

 private:
  static constexpr const char* tables[] = {"file", "seen", "look", "tile"};
  static constexpr const char* columns[][6] = {{"name", "crc32", "bytes", "fault", "contents", "contents"},
                                               {"name", "bytes", "modified", "fault", "bytes", "modified"},
                                               {"keyframe", "digest", "bytes", "keyframe", "digest", "bytes"},
                                               {"strip", "row", "column", "digest", "summary", "cells"}};

  void run(const std::string& sql) {
    require(sqlite3_exec(writer_, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK, sqlite3_errmsg(writer_));
  }
  void run(sqlite3_stmt* statement) {
    require(sqlite3_step(statement) == SQLITE_DONE && sqlite3_reset(statement) == SQLITE_OK, sqlite3_errmsg(writer_));
  }
  sqlite3_stmt* prepared(const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    require(sqlite3_prepare_v2(writer_, sql.c_str(), -1, &statement, nullptr) == SQLITE_OK, sqlite3_errmsg(writer_));
    return statement;
  }

  /// Any value in any column of some rows, or a file with changes that its checksum does not show.
  void change_cell(Choices& choices) {
    const std::size_t table = choices.byte() % std::size(tables);
    changed_[table] = true;
    if (table == 0 && choices.byte() % 2 == 0) return change_contents(choices);
    const std::string column = columns[table][choices.byte() % 6];
    const std::string rows = " WHERE " + std::string(columns[table][0]) + " IN (SELECT " + columns[table][0] +
                             " FROM known_" + tables[table] + " LIMIT 1 OFFSET " + std::to_string(choices.byte() % 8) +
                             ")";
    sqlite3_stmt* statement =
        prepared("UPDATE OR IGNORE main." + std::string(tables[table]) + " SET " + column + " = ?" + rows);
    const std::uint8_t kind = choices.byte();
    const Octets octets = kind % 5 < 2 ? choices.bytes() : Octets{};
    const auto size = static_cast<int>(octets.size());
    if (kind % 5 == 0) sqlite3_bind_text(statement, 1, reinterpret_cast<const char*>(octets.data()), size, nullptr);
    if (kind % 5 == 1) sqlite3_bind_blob(statement, 1, octets.data(), size, nullptr);
    if (kind % 5 == 2) sqlite3_bind_int64(statement, 1, static_cast<std::int64_t>(choices.number(8)));
    if (kind % 5 == 3) sqlite3_bind_double(statement, 1, static_cast<double>(choices.number(8)) / 3);
    sqlite3_step(statement);  // null in a key is refused, which is as good
    sqlite3_finalize(statement);
  }

  void change_contents(Choices& choices) {
    KnownFile file = known_outbox()[choices.byte() % known_outbox().size()];
    fuzz::change(choices, file);
    sqlite3_stmt* statement = prepared("UPDATE main.file SET contents = ?, crc32 = ? WHERE name = ?");
    sqlite3_bind_blob64(statement, 1, file.bytes.data(), file.bytes.size(), nullptr);
    sqlite3_bind_int64(statement, 2, crc32(file.bytes));
    sqlite3_bind_text(statement, 3, file.name.c_str(), -1, nullptr);
    sqlite3_step(statement);
    sqlite3_finalize(statement);
  }

  const test::TemporaryFolder folder_;
  std::unique_ptr<intake::Catalogue> catalogue_;
  sqlite3* writer_ = nullptr;
  /// By table.
  std::array<bool, 4> changed_{};
  std::array<sqlite3_stmt*, 4> empty_{}, fill_{};
};

}  // namespace

void ground_catalogue(Octets input) {
  static OpenCatalogue open;
  Choices choices(input);
  const std::uint8_t what = choices.byte();
  open.change(choices, what);
  try {
    use(open.catalogue(), open.outbox(), what);
  } catch (const std::runtime_error&) {
  }
}

void ground_catalogue_file(Octets input) {
  Choices choices(input);
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "catalogue.db", outbox = folder.path() / "outbox";
  KnownFile database = known_catalogue();
  // Any page, not only the first ones.
  for (int i = 0; i < 4 && !choices.empty() && !database.bytes.empty(); ++i) {
    const std::size_t at = choices.u32() % database.bytes.size();
    KnownFile part{"", {database.bytes.begin() + static_cast<std::ptrdiff_t>(at), database.bytes.end()}};
    part.name = ".jp2";
    change(choices, part);
    database.bytes.resize(at);
    database.bytes.insert(database.bytes.end(), part.bytes.begin(), part.bytes.end());
  }
  host::write_file(path, database.bytes);
  fs::create_directories(outbox);
  for (std::size_t i = 0; i < 2; ++i) {
    const KnownFile& known = known_outbox()[choices.byte() % known_outbox().size()];
    host::write_file(outbox / known.name, known.bytes);
  }
  // Not everything every time: most inputs are bad at the first look.
  const std::uint8_t what = choices.byte();
  try {
    intake::Catalogue catalogue(path);
    use(catalogue, outbox, what);
  } catch (const std::runtime_error&) {
  }
}

}  // namespace ilp::fuzz
