// The database under the catalogue: an SQLite file, or a server that several missions share. Both understand the
// statements of catalogue.cpp. Functions throw std::runtime_error with a message for the user.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ilp::intake {

/// A prepared statement. Each bind() sets the parameter of the next question mark.
class Statement {
 public:
  virtual ~Statement() = default;
  virtual Statement& bind(std::int64_t value) = 0;
  virtual Statement& bind(const std::string& text) = 0;
  /// The bytes must stay valid until the statement has run.
  virtual Statement& bind(std::span<const std::uint8_t> bytes) = 0;
  /// Goes to the next row of the result; false if there is none.
  virtual bool step() = 0;
  [[nodiscard]] virtual std::int64_t integer(int column) = 0;
  [[nodiscard]] virtual std::vector<std::uint8_t> bytes(int column) = 0;

  void run() {
    while (step()) {
    }
  }
  [[nodiscard]] std::string text(int column) {
    const std::vector<std::uint8_t> octets = bytes(column);
    return {octets.begin(), octets.end()};
  }
};

class CatalogueDatabase {
 public:
  virtual ~CatalogueDatabase() = default;
  /// Prepares a statement. Its text has the marks {and} before a condition, {key} before a list of columns, and {value}
  /// before a list of values: a server inserts the mission there, a file nothing. `large`: rows are fetched one by one
  /// to save memory, and no other statement may run before this one has ended.
  [[nodiscard]] virtual std::unique_ptr<Statement> prepare(const std::string& sql, bool large = false) = 0;
  virtual void begin() = 0;
  virtual void commit() = 0;
  virtual void roll_back() noexcept = 0;

  /// On a server, the number that keep_mark() had stored last when the database was opened; 0 for a file, whose changes
  /// its size and times show.
  virtual std::uint64_t mark() { return 0; }
  virtual void keep_mark(std::uint64_t) {}
};

/// Replaces the marks {and}, {key} and {value} of a statement.
[[nodiscard]] std::string with_mission(std::string sql, const std::string& condition, const std::string& key,
                                       const std::string& value);

/// Opens or creates a file. Null if it is damaged or of another version. `known_valid`: as in Catalogue's constructor.
[[nodiscard]] std::unique_ptr<CatalogueDatabase> open_catalogue_file(const std::filesystem::path& file,
                                                                     bool known_valid);

/// Opens the mission's part of a database on a server, and creates missing tables. Only one process at a time may use
/// the part of a mission.
[[nodiscard]] std::unique_ptr<CatalogueDatabase> open_catalogue_server(const std::string& address,
                                                                       const std::string& mission);

}  // namespace ilp::intake
