// Answers of the server that are still true: a question that was answered since its table changed is not asked again.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/records/field.hpp"

namespace ilp::postgres {

enum class Question : std::uint8_t { get, next, last, count };

/// Only whole records and "there is none" are kept, never damage. Each answer has a checksum, so that a flipped bit
/// makes it a miss.
class AnswerCache {
 public:
  struct Answer {
    bool found = false;
    std::int64_t count = 0;  ///< of Question::count
    alignas(8) std::array<std::uint8_t, limits::max_record_bytes> record{};
  };

  /// nullptr when it is not known. `key` is the id asked for (get), the id before (next), or 0.
  [[nodiscard]] const Answer* find(const RecordInfo& info, Question question, std::int64_t key) const;
  /// `record` is nullptr when there is none.
  void keep(const RecordInfo& info, Question question, std::int64_t key, const void* record);
  void keep_count(const RecordInfo& info, std::int64_t records);
  /// All answers about these tables become unknown.
  void forget(RecordMask tables);
  /// Those that a put or an erasure of this id may have made untrue.
  void forget_record(const RecordInfo& info, std::int64_t id);

 private:
  struct Entry {
    std::uint64_t check = 0;
    std::int64_t key = 0;
    std::uint32_t epoch = 0;  ///< of the table, when it was kept; 0: empty
    RecordType type = RecordType::count;
    Question question = Question::get;
    Answer answer;
  };
  static constexpr std::size_t places = 1024;

  [[nodiscard]] static std::size_t place_of(RecordType type, Question question, std::int64_t key);
  [[nodiscard]] static std::uint64_t check_of(const RecordInfo& info, const Entry& entry);
  [[nodiscard]] std::uint32_t epoch_of(RecordType type) const { return epochs_[static_cast<std::size_t>(type)]; }
  Entry& entry_for(const RecordInfo& info, Question question, std::int64_t key);

  std::array<std::uint32_t, static_cast<std::size_t>(RecordType::count)> epochs_ = [] {
    std::array<std::uint32_t, static_cast<std::size_t>(RecordType::count)> ones{};
    ones.fill(1);
    return ones;
  }();
  std::array<Entry, places> entries_{};
};

}  // namespace ilp::postgres
