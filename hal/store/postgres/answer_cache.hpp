// Answers of the server that are still true: a question that was answered since its table changed is not asked again.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/records/field.hpp"

namespace ilp::postgres {

enum class Question : std::uint8_t { get, next, last };

/// Only whole records and "there is none" are kept, never damage. Each answer has a checksum, so that a flipped bit
/// makes it a miss.
class AnswerCache {
 public:
  struct Answer {
    bool found = false;
    const std::uint8_t* record = nullptr;  ///< until the next call that keeps something
  };

  /// Returns false when it is not known. `key` is the id asked for (get), the id before (next), or 0.
  [[nodiscard]] bool find(const RecordInfo& info, Question question, std::int64_t key, Answer& answer);
  /// `record` is nullptr when there is none.
  void keep(const RecordInfo& info, Question question, std::int64_t key, const void* record);
  /// All answers about these tables become unknown.
  void forget(RecordMask tables);
  /// All answers are as after a put of this record.
  void put(const RecordInfo& info, const void* record);
  /// Those that an erasure of this id may have made untrue become unknown.
  void erase(const RecordInfo& info, std::int64_t id);

 private:
  /// What a place holds. The record is apart, so that a search through all places is fast.
  struct Head {
    std::int64_t key = 0;
    std::int64_t id = 0;      ///< of the record
    std::uint64_t check = 0;  ///< of the rest and the record
    std::uint64_t epoch = 0;  ///< of the table, when it was kept; 0: empty
    std::uint64_t used = 0;   ///< larger: used later
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
