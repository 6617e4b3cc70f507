// Data that a flight keeps in nonvolatile memory, because it must not lose them with its database: the number of its
// store epoch, used transaction numbers, sequence numbers of authentication, and the configurations that decide whether
// the ground can reach it (docs/getting-back-in.md).
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/time.hpp"
#include "fsw/packets/authentication.hpp"
#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

struct KeptSetting {
  std::uint64_t number = 0;  ///< number of the parameter (ParameterInfo)
  double value = 0;
};

/// Parameters that were set by telecommand, each once, in no particular order.
struct KeptSettings {
  static constexpr std::size_t capacity = 192;
  std::uint64_t count = 0;
  std::array<KeptSetting, capacity> items{};

  /// Returns the null pointer if the parameter is not set.
  [[nodiscard]] const KeptSetting* find(std::uint64_t number) const;
  /// Sets the parameter. Returns false if it is a further one and the capacity is exhausted.
  [[nodiscard]] bool set(std::uint64_t number, double value);
  void remove(std::uint64_t number);
};

struct FlightMemoryContent {
  /// Raised when the meaning of the content changes. Content with another layout is not read.
  static constexpr std::uint32_t current_layout = 1;
  std::uint32_t layout = current_layout;
  std::uint32_t starts_unconfirmed = 0;             ///< starts in a row that no telecommand has confirmed
  std::int64_t life = 0;                            ///< the latest store epoch that was begun; 0: none
  std::int64_t keyframe_base = 0, record_base = 0;  ///< bases of that store epoch's ids (IdentityRecord)
  std::int64_t transactions_reserved = 0;           ///< CFDP transaction numbers up to this one may have been used
  std::int64_t configuration = 0;                   ///< grows with every change of the settings
  TimeNs latest_ns = 0;                             ///< latest known mission time
  TimeNs tentative_ns = 0;                          ///< time in contact since tentative settings were first used
  double mission_epoch_s = 0;                       ///< as the mission parameter
  std::uint64_t epoch_known = 0;                    ///< not 0: mission_epoch_s is valid
  std::array<SequenceMark, limits::max_security_associations> marks{};  ///< SPI 0: none
  KeptSettings good;    ///< confirmed settings, and settings that need no confirmation
  KeptSettings wanted;  ///< `good` and the tentative settings
};
static_assert(sizeof(FlightMemoryContent) <= max_nonvolatile_bytes);

/// Holds the content in memory and on its medium. The content in memory has a checksum: a flipped bit is detected at
/// the next use, and the content is then read again from the medium.
class FlightMemory {
 public:
  explicit FlightMemory(Nonvolatile& medium) : medium_(medium) {}

  /// Reads the content from the medium. Call it before any other function. Returns `not_found` if the medium is empty,
  /// `record_damaged` if the content is lost, and `io_error` if it cannot be read; the content is then the default one.
  Status load();
  [[nodiscard]] const FlightMemoryContent& content();
  /// Replaces the content in memory and on the medium. If the medium cannot be written, the new content stays in
  /// memory, and the fault is returned.
  Status keep(const FlightMemoryContent& content);
  /// The Status of the latest keep().
  [[nodiscard]] const Status& kept() const { return kept_; }

  /// Returns a CFDP transaction number that no transaction of this flight has had, in any store epoch. `latest` is the
  /// latest number that the caller knows of. Numbers are reserved on the medium in blocks; the rest of a block is
  /// skipped when the process ends.
  [[nodiscard]] std::int64_t next_transaction(std::int64_t latest);
  /// Lets next_transaction() continue after `through`, for a medium that keeps nothing.
  void skip_transactions(std::int64_t through);

 private:
  void seal();
  static bool valid(const FlightMemoryContent& content);

  Nonvolatile& medium_;
  FlightMemoryContent content_;
  std::uint32_t crc_ = 0;
  bool sealed_ = false;
  std::int64_t transactions_used_ = 0;
  Status kept_;
};

}  // namespace ilp
