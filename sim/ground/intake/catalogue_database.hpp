// The database below the catalogue: a file, or a server that many missions share. Both understand the statements of
// catalogue.cpp. Every function throws std::runtime_error with a message for the user.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ilp::intake {

/// A statement with its parameters, which are bound in the order of the question marks.
class Statement {
 public:
  virtual ~Statement() = default;
  virtual Statement& bind(std::int64_t value) = 0;
  virtual Statement& bind(const std::string& text) = 0;
  /// The bytes must live until the statement has run.
  virtual Statement& bind(std::span<const std::uint8_t> bytes) = 0;
  /// True while there is a row.
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
  /// In the text, {and} stands before a condition, {key} before a list of columns and {value} before a list of values:
  /// a server adds the mission there. Other statements may run before this one has ended, unless it is `large`: then
  /// its rows come one after the other, and do not take memory together.
  [[nodiscard]] virtual std::unique_ptr<Statement> prepare(const std::string& sql, bool large = false) = 0;
  virtual void begin() = 0;
  virtual void commit() = 0;
  virtual void roll_back() noexcept = 0;

  /// On a server, the number that was kept last when the database was opened. A file is watched as a file.
  virtual std::uint64_t mark() { return 0; }
  virtual void keep_mark(std::uint64_t) {}
};

/// Replaces {and}, {key} and {value}.
[[nodiscard]] std::string with_mission(std::string sql, const std::string& condition, const std::string& key,
                                       const std::string& value);

/// Null when the file is damaged, or of another version. `known_valid`: it need not be read whole to find damage.
[[nodiscard]] std::unique_ptr<CatalogueDatabase> open_catalogue_file(const std::filesystem::path& file,
                                                                     bool known_valid);

/// The part of a mission, which one process at a time may use. Creates the tables where they are missing.
[[nodiscard]] std::unique_ptr<CatalogueDatabase> open_catalogue_server(const std::string& address,
                                                                       const std::string& mission);

}  // namespace ilp::intake
