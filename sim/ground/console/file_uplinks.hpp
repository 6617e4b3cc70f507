// Sends the operator's files to the flight.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/ground/console/console.hpp"

namespace ilp::console {

class FileUplinks {
 public:
  /// Shows a line to the operator.
  using Say = std::function<void(const std::string&)>;

  FileUplinks(Console& console, Say say) : console_(console), say_(std::move(say)) {}

  /// Sends a file, or the files of a map's folder: its directory, then its tiles one after another. `words`: the
  /// operator's line. Throws std::runtime_error that says what is wrong with a file; then none is sent.
  void send(const std::filesystem::path& path, const std::string& words);
  /// Reports which files the flight has accepted or refused, and sends the next ones; to be called regularly.
  void watch();
  /// Lines of the operator whose files are not all sent yet.
  [[nodiscard]] std::vector<std::string> waiting() const;
  /// Number of lines of which a file could not be read or was refused by the flight.
  [[nodiscard]] std::size_t failures() const { return failures_; }

 private:
  struct Order {
    std::string words;
    std::deque<std::filesystem::path> files;  ///< remaining files; the first one is being sent
    std::uint64_t transaction = 0;            ///< transaction number of the first one
  };

  void put_first(Order& order);
  bool is_over(Order& order);

  Console& console_;
  Say say_;
  std::vector<Order> orders_;
  std::size_t failures_ = 0;
};

}  // namespace ilp::console
