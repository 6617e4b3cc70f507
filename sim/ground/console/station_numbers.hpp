// Numbers that a ground station uses once in its life, kept over its restarts: sequence numbers of security
// associations and numbers of file transactions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

namespace ilp::console {

class StationNumbers {
 public:
  /// Without a file, numbers begin from the calendar, whose clock must not go back.
  StationNumbers();
  /// Continues after the numbers in the file, or from the calendar if that is later or there is no file yet. Throws
  /// std::runtime_error when the file is damaged, cannot be written, or another station uses it.
  explicit StationNumbers(std::filesystem::path file);
  ~StationNumbers();
  StationNumbers(const StationNumbers&) = delete;
  StationNumbers& operator=(const StationNumbers&) = delete;

  /// Returns each number once. Throws std::runtime_error when it cannot be kept, or all are used up.
  [[nodiscard]] std::uint32_t next_sequence(std::uint16_t spi);
  [[nodiscard]] std::uint64_t next_transaction();

 private:
  /// The file has the end of the reserved numbers: after a restart no number below it is used.
  struct Counter {
    std::uint64_t next = 0, reserved = 0;
  };
  static constexpr std::uint32_t transactions = 0;  ///< their counter; the others have their SPI
  std::uint64_t take(std::uint32_t which, std::uint64_t first, std::uint64_t last);
  void read();
  void write() const;

  std::filesystem::path file_;
  int lock_ = -1;
  std::map<std::uint32_t, Counter> counters_;
};

}  // namespace ilp::console
