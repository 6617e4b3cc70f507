// Files that the operator sends up.
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
  /// A line for the operator.
  using Say = std::function<void(const std::string&)>;

  FileUplinks(Console& console, Say say) : console_(console), say_(std::move(say)) {}

  /// Sends a file, or the files of a map's folder: its directory, then its tiles one after another. `words` is what the
  /// operator typed. std::runtime_error says what is wrong with a file; then none is sent.
  void send(const std::filesystem::path& path, const std::string& words);
  /// Says which files the flight has taken or refused, and sends the next ones.
  void watch();
  /// What is not done yet, as it was typed.
  [[nodiscard]] std::vector<std::string> waiting() const;
  /// Files that the flight has not taken.
  [[nodiscard]] std::size_t failures() const { return failures_; }

 private:
  struct Order {
    std::string words;
    std::deque<std::filesystem::path> files;  ///< the first one is under way
    std::uint64_t transaction = 0;            ///< of that one
  };

  void put_first(Order& order);
  bool is_over(Order& order);

  Console& console_;
  Say say_;
  std::vector<Order> orders_;
  std::size_t failures_ = 0;
};

}  // namespace ilp::console
