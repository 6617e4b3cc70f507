// What a transaction has read before it has the store to itself.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/field.hpp"
#include "hal/store/postgres/guesses.hpp"

namespace ilp::postgres {

/// Most transactions find nothing to do and write nothing. They need no lock as long as all that they ask is known. The
/// first write takes the lock; then what they have read has to be true still.
class EarlyReads {
 public:
  struct Read {
    Asked asked;
    std::uint64_t check = 0;
  };

  void clear() { reads_.clear(); }
  [[nodiscard]] bool empty() const { return reads_.empty(); }
  [[nodiscard]] bool full() const { return reads_.size() == capacity; }
  /// `record` is nullptr when there is none. Not when it is full.
  void note(const Asked& asked, const RecordInfo& info, const void* record) {
    static_cast<void>(reads_.push_back({asked, check_of(info, record)}));
  }
  [[nodiscard]] std::size_t size() const { return reads_.size(); }
  [[nodiscard]] const Read& operator[](std::size_t place) const { return reads_[place]; }

  /// The same for the same answer.
  [[nodiscard]] static std::uint64_t check_of(const RecordInfo& info, const void* record) {
    if (record == nullptr) return 0;
    return checksum64(std::as_bytes(std::span(static_cast<const std::uint8_t*>(record), info.bytes)), 1);
  }

 private:
  static constexpr std::size_t capacity = 1024;
  FixedVector<Read, capacity> reads_;
};

}  // namespace ilp::postgres
