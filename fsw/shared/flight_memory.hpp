// What a flight must not lose with its database: which life it is in, numbers that were used, replay marks, and the
// configurations that decide whether it can be reached (docs/getting-back-in.md).
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/time.hpp"
#include "fsw/link/authentication.hpp"
#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

struct KeptSetting {
  std::uint64_t number = 0;  ///< of the parameter
  double value = 0;
};

/// Parameters that were set by telecommand, in no order; each once.
struct KeptSettings {
  static constexpr std::size_t capacity = 192;
  std::uint64_t count = 0;
  std::array<KeptSetting, capacity> items{};

  /// The null pointer where it is not set.
  [[nodiscard]] const KeptSetting* find(std::uint64_t number) const;
  /// False when there is no room for one more.
  [[nodiscard]] bool set(std::uint64_t number, double value);
  void remove(std::uint64_t number);
};

struct FlightMemoryContent {
  /// Raised with a change of meaning; what has another one is not read.
  static constexpr std::uint32_t current_layout = 1;
  std::uint32_t layout = current_layout;
  std::uint32_t starts_unconfirmed = 0;             ///< in a row, of which none was confirmed by a telecommand
  std::int64_t life = 0;                            ///< the latest that was begun, 0: none
  std::int64_t keyframe_base = 0, record_base = 0;  ///< of that life (IdentityRecord)
  std::int64_t transactions_reserved = 0;           ///< CFDP transactions up to it may have been used
  std::int64_t configuration = 0;                   ///< grows with every change of the settings
  TimeNs latest_ns = 0;                             ///< mission time was this far
  TimeNs trial_ns = 0;                              ///< contact since something is on trial
  double mission_epoch_s = 0;
  std::uint64_t epoch_known = 0;
  std::array<SequenceMark, limits::max_security_associations> marks{};  ///< SPI 0: none
  KeptSettings good;                                                    ///< confirmed, or of a kind that needs no trial
  KeptSettings wanted;                                                  ///< `good` with what is on trial
};
static_assert(sizeof(FlightMemoryContent) <= max_nonvolatile_bytes);

/// The content in memory and on its medium. In memory it has a checksum: a flipped bit is noticed at the next use, and
/// the medium's content taken instead.
class FlightMemory {
 public:
  explicit FlightMemory(Nonvolatile& medium) : medium_(medium) {}

  /// To be called before anything else. `not_found`: there is nothing yet. `record_damaged`, `io_error`: what was there
  /// is lost or cannot be read; the flight begins with an empty content.
  Status load();
  [[nodiscard]] const FlightMemoryContent& content();
  /// Writes through. Where that fails the content in memory is the new one all the same, and the Status says why.
  Status keep(const FlightMemoryContent& content);
  /// What the latest keep() said.
  [[nodiscard]] const Status& kept() const { return kept_; }

  /// The next CFDP transaction number, which no transaction of this flight has had: not in another life, not before a
  /// restart. Numbers are reserved on the medium in blocks; what is left of a block when the process ends is skipped.
  /// `latest` is the latest number that the caller knows of.
  [[nodiscard]] std::int64_t next_transaction(std::int64_t latest);
  /// Where nothing can be kept: numbers go on behind this one.
  void skip_transactions(std::int64_t through);

 private:
  void seal();
  static bool sound(const FlightMemoryContent& content);

  Nonvolatile& medium_;
  FlightMemoryContent content_;
  std::uint32_t crc_ = 0;
  bool sealed_ = false;
  std::int64_t transactions_used_ = 0;
  Status kept_;
};

}  // namespace ilp
