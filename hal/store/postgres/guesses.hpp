// Guesses what a transaction asks next: a step asks the same questions in the same order as the one before.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/records/field.hpp"
#include "hal/store/postgres/sql_text.hpp"

namespace ilp::postgres {

struct Asked {
  RecordType type = RecordType::count;  ///< count: nothing
  RowVerb verb = RowVerb::get;
  std::int64_t key = 0;

  bool operator==(const Asked&) const = default;
};

/// Only a guess: a wrong one costs the server a moment.
class Guesses {
 public:
  void begin_transaction() { latest_ = {}; }
  /// `asked` had to be asked in this transaction.
  void learn(const Asked& asked) {
    if (latest_.type != RecordType::count) pairs_[place_of(latest_)] = {latest_, asked};
    latest_ = asked;
  }
  /// What was asked behind `asked` the last time; of type `count` when that is not known.
  [[nodiscard]] Asked after(const Asked& asked) const {
    const Pair& pair = pairs_[place_of(asked)];
    return pair.first == asked ? pair.second : Asked{};
  }

 private:
  struct Pair {
    Asked first, second;
  };
  [[nodiscard]] static std::size_t place_of(const Asked& asked) {
    const std::uint64_t hash = (static_cast<std::uint64_t>(asked.key) * 64 +
                                static_cast<std::uint64_t>(asked.type) * 4 + static_cast<std::uint64_t>(asked.verb)) *
                               0x9E3779B97F4A7C15U;
    return static_cast<std::size_t>(hash >> 56U);
  }

  std::array<Pair, 256> pairs_{};
  Asked latest_;
};

}  // namespace ilp::postgres
