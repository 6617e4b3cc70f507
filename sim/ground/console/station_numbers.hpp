// Issues numbers that a ground station must never use twice, also after restarts: sequence numbers of security
// associations, and numbers of file transactions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>

namespace ilp::console {

class StationNumbers {
 public:
  /// Without a file. Numbers start from the calendar time, so that the computer's clock must not go back.
  StationNumbers();
  /// Continues after the numbers in the file, or from the calendar time if that is larger or there is no file yet.
  /// Throws std::runtime_error if the file is damaged, cannot be written, or is used by another station.
  explicit StationNumbers(std::filesystem::path file);
  ~StationNumbers();
  StationNumbers(const StationNumbers&) = delete;
  StationNumbers& operator=(const StationNumbers&) = delete;

  /// Return each number once. Throw std::runtime_error if the file cannot be written, or no number is left.
  [[nodiscard]] std::uint32_t next_sequence(std::uint16_t spi);
  [[nodiscard]] std::uint64_t next_transaction();

 private:
  /// The file contains `reserved`, the end of the reserved numbers. After a restart no smaller number is used.
  struct Counter {
    std::uint64_t next = 0, reserved = 0;
  };
  static constexpr std::uint32_t transactions = 0;  ///< key of the counter of transactions; other keys are SPIs
  std::uint64_t take(std::uint32_t which, std::uint64_t first, std::uint64_t last);
  void read();
  void write() const;

  std::filesystem::path file_;
  int lock_ = -1;
  std::map<std::uint32_t, Counter> counters_;
};

}  // namespace ilp::console
