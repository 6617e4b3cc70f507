#include "hal/store/postgres/answer_cache.hpp"

#include <cstring>
#include <span>

#include "fsw/base/checksum.hpp"
#include "hal/store/record_bytes.hpp"

namespace ilp::postgres {

// The mixing function of SplitMix64.
std::size_t AnswerCache::set_of(RecordType type, Question question, std::int64_t key) {
  std::uint64_t hash = static_cast<std::uint64_t>(key) + (static_cast<std::uint64_t>(type) << 48U) +
                       (static_cast<std::uint64_t>(question) << 60U) + 0x9E3779B97F4A7C15U;
  hash = (hash ^ hash >> 30U) * 0xBF58476D1CE4E5B9U;
  hash = (hash ^ hash >> 27U) * 0x94D049BB133111EBU;
  return static_cast<std::size_t>((hash ^ hash >> 31U) % sets);
}

std::uint64_t AnswerCache::check_of(const RecordInfo& info, std::size_t place) const {
  const Head& head = heads_[place];
  const std::int64_t words[] = {head.key,
                                head.id,
                                static_cast<std::int64_t>(head.epoch),
                                static_cast<std::int64_t>(head.type),
                                static_cast<std::int64_t>(head.question),
                                head.found ? 1 : 0};
  const std::uint64_t sum = checksum64(memory_of(words));
  return head.found ? checksum64(std::as_bytes(std::span(records_[place]).first(info.bytes)), sum) : sum;
}

bool AnswerCache::is_it(const Head& head, const RecordInfo& info, Question question, std::int64_t key) const {
  return head.type == info.type && head.question == question && head.key == key && head.epoch == epoch_of(info.type);
}

bool AnswerCache::find(const RecordInfo& info, Question question, std::int64_t key, Answer& answer) {
  const std::size_t first = set_of(info.type, question, key) * ways;
  for (std::size_t place = first; place < first + ways; ++place) {
    Head& head = heads_[place];
    if (!is_it(head, info, question, key) || !is_valid(info, place)) continue;
    head.used = ++uses_;
    answer = {head.found, records_[place].data()};
    return true;
  }
  return false;
}

/// The place of this question, an empty one, or the one that was used longest ago.
std::size_t AnswerCache::place_for(const RecordInfo& info, Question question, std::int64_t key) const {
  const std::size_t first = set_of(info.type, question, key) * ways;
  std::size_t best = first;
  for (std::size_t place = first; place < first + ways; ++place) {
    const Head& head = heads_[place];
    if (is_it(head, info, question, key)) return place;
    const auto is_empty = [&](const Head& one) {
      return one.type == RecordType::count || one.epoch != epoch_of(one.type);
    };
    if (is_empty(heads_[best])) continue;
    if (is_empty(head) || head.used < heads_[best].used) best = place;
  }
  return best;
}

void AnswerCache::keep(const RecordInfo& info, Question question, std::int64_t key, const void* record) {
  const std::size_t place = place_for(info, question, key);
  heads_[place] = {key, 0, 0, epoch_of(info.type), ++uses_, info.type, question, false};
  fill(info, place, record);
}

void AnswerCache::fill(const RecordInfo& info, std::size_t place, const void* record) {
  Head& head = heads_[place];
  head.found = record != nullptr;
  head.id = 0;
  if (record != nullptr) {
    head.id = id_of(record);
    std::memcpy(records_[place].data(), record, info.bytes);
  }
  head.check = check_of(info, place);
}

void AnswerCache::forget(RecordMask tables_to_forget) {
  for (std::size_t t = 0; t < tables; ++t) {
    if ((tables_to_forget >> t & 1U) != 0) ++epochs_[t];
  }
}

/// What came behind the records before this one comes behind this one now.
void AnswerCache::put(const RecordInfo& info, const void* record) {
  const std::int64_t id = id_of(record);
  bool follower_is_known = false;
  bool is_followed = false;
  alignas(8) Record follower;
  for (std::size_t place = 0; place < heads_.size(); ++place) {
    Head& head = heads_[place];
    if (head.type != info.type || head.epoch != epoch_of(info.type)) continue;
    const bool next = head.question == Question::next && head.key < id && (!head.found || head.id >= id);
    const bool last = head.question == Question::last && (!head.found || head.id <= id);
    if (!next && !last) continue;
    if (!is_valid(info, place)) {
      head.epoch = 0;
      continue;
    }
    if (next && !(head.found && head.id == id)) {
      follower_is_known = true;
      is_followed = head.found;
      follower = records_[place];
    }
    fill(info, place, record);
  }
  keep(info, Question::get, id, record);
  if (follower_is_known) keep(info, Question::next, id, is_followed ? follower.data() : nullptr);
}

void AnswerCache::erase(const RecordInfo& info, std::int64_t id) {
  for (Head& head : heads_) {
    if (head.type != info.type) continue;
    const bool untrue = head.question == Question::get ? head.key == id : head.found && head.id == id;
    if (untrue) head.epoch = 0;
  }
}

}  // namespace ilp::postgres
