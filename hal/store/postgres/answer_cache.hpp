// Caches answers of the server. A question is not sent again if it was answered since the latest change of its table.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/records/field.hpp"

namespace ilp::postgres {

/// The call of Store that asks.
enum class Question : std::uint8_t { get, next, last };

/// A set-associative cache with replacement of the least recently used answer. It keeps undamaged records and the
/// answer that there is none. Each answer has a checksum; an answer with a wrong one counts as a miss.
class AnswerCache {
 public:
  struct Answer {
    bool found = false;                    ///< there is a record
    const std::uint8_t* record = nullptr;  ///< the record; valid until the next call of keep() or put()
  };

  /// Looks an answer up. Returns false if it is not in the cache. `key` is the argument `id` of get(), the argument
  /// `after` of next(), or 0 for last().
  [[nodiscard]] bool find(const RecordInfo& info, Question question, std::int64_t key, Answer& answer);
  /// Enters an answer. A null `record` means that there is none.
  void keep(const RecordInfo& info, Question question, std::int64_t key, const void* record);
  /// Drops all answers about these tables.
  void forget(RecordMask tables);
  /// Updates the answers for a put of this record.
  void put(const RecordInfo& info, const void* record);
  /// Drops the answers that the erasure of this id may have changed.
  void erase(const RecordInfo& info, std::int64_t id);

 private:
  /// An entry without its record. Records are stored apart, so that a search through all entries is fast.
  struct Head {
    std::int64_t key = 0;
    std::int64_t id = 0;      ///< id of the record
    std::uint64_t check = 0;  ///< checksum of the other members but `used`, and of the record
    std::uint64_t epoch = 0;  ///< value of `epochs_` when the answer was entered; 0: empty
    std::uint64_t used = 0;   ///< value of `uses_` at the latest use
    RecordType type = RecordType::count;
    Question question = Question::get;
    bool found = false;
  };
  using Record = std::array<std::uint8_t, limits::max_record_bytes>;
  static constexpr std::size_t sets = 1024;
  static constexpr std::size_t ways = 4;
  static constexpr std::size_t tables = static_cast<std::size_t>(RecordType::count);

  [[nodiscard]] static std::size_t set_of(RecordType type, Question question, std::int64_t key);
  [[nodiscard]] std::uint64_t check_of(const RecordInfo& info, std::size_t place) const;
  [[nodiscard]] std::uint64_t epoch_of(RecordType type) const { return epochs_[static_cast<std::size_t>(type)]; }
  [[nodiscard]] bool is_valid(const RecordInfo& info, std::size_t place) const {
    return heads_[place].check == check_of(info, place);
  }
  void fill(const RecordInfo& info, std::size_t place, const void* record);
  [[nodiscard]] bool is_it(const Head& head, const RecordInfo& info, Question question, std::int64_t key) const;
  [[nodiscard]] std::size_t place_for(const RecordInfo& info, Question question, std::int64_t key) const;

  /// For each table, a number that forget() raises: answers with an earlier number are dropped.
  std::array<std::uint64_t, tables> epochs_ = [] {
    std::array<std::uint64_t, tables> ones{};
    ones.fill(1);
    return ones;
  }();
  std::uint64_t uses_ = 0;
  std::array<Head, sets * ways> heads_{};
  alignas(8) std::array<Record, sets * ways> records_{};
};

}  // namespace ilp::postgres
