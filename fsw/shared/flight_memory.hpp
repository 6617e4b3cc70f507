// Data that a flight must not lose with its database: the number of its store epoch, numbers that were used, replay
// marks, and the configurations that decide whether it can be reached (docs/getting-back-in.md).
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/time.hpp"
#include "fsw/packets/authentication.hpp"
#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

struct KeptSetting {
  std::uint64_t number = 0;  ///< number of the parameter
  double value = 0;
};

/// Parameters that were set by telecommand, each once, in no order.
struct KeptSettings {
  static constexpr std::size_t capacity = 192;
  std::uint64_t count = 0;
  std::array<KeptSetting, capacity> items{};

  /// Returns the null pointer if it is not set.
  [[nodiscard]] const KeptSetting* find(std::uint64_t number) const;
  /// Returns false when there is no room for one more.
  [[nodiscard]] bool set(std::uint64_t number, double value);
  void remove(std::uint64_t number);
};

struct FlightMemoryContent {
  /// Raised with a change of meaning. Content with another layout is not read.
  static constexpr std::uint32_t current_layout = 1;
  std::uint32_t layout = current_layout;
  std::uint32_t starts_unconfirmed = 0;             ///< starts in a row that no telecommand has confirmed
  std::int64_t life = 0;                            ///< the latest store epoch that was begun; 0: none
  std::int64_t keyframe_base = 0, record_base = 0;  ///< of that store epoch (IdentityRecord)
  std::int64_t transactions_reserved = 0;           ///< CFDP transaction numbers up to it may have been used
  std::int64_t configuration = 0;                   ///< grows with every change of the settings
  TimeNs latest_ns = 0;                             ///< latest known mission time
  TimeNs tentative_ns = 0;                          ///< time in contact since the trial began
  double mission_epoch_s = 0;
  std::uint64_t epoch_known = 0;
  std::array<SequenceMark, limits::max_security_associations> marks{};  ///< SPI 0: none
  KeptSettings good;    ///< confirmed settings, and those that need no trial
  KeptSettings wanted;  ///< `good` with the tentative settings
};
static_assert(sizeof(FlightMemoryContent) <= max_nonvolatile_bytes);

/// The content in memory and on its medium. In memory it has a checksum: a flipped bit is detected at the next use, and
/// the content is read from the medium.
class FlightMemory {
 public:
  explicit FlightMemory(Nonvolatile& medium) : medium_(medium) {}

  /// Call it before anything else. `not_found`: there is nothing yet. `record_damaged`, `io_error`: the content is lost
  /// or cannot be read; the flight begins with an empty content.
  Status load();
  [[nodiscard]] const FlightMemoryContent& content();
  /// Writes through to the medium. If that fails the content in memory is still the new one, and the Status gives the
  /// fault.
  Status keep(const FlightMemoryContent& content);
  /// The Status of the latest keep().
  [[nodiscard]] const Status& kept() const { return kept_; }

  /// The next CFDP transaction number, which no transaction of this flight has had, in this store epoch or an earlier
  /// one. Numbers are reserved on the medium in blocks. The rest of a block is skipped when the process ends. `latest`
  /// is the latest number that the caller knows of.
  [[nodiscard]] std::int64_t next_transaction(std::int64_t latest);
  /// Numbers continue after this one. It is for a medium that keeps nothing.
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
