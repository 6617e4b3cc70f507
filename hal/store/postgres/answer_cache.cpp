#include "hal/store/postgres/answer_cache.hpp"

#include <cstring>

#include "fsw/base/checksum.hpp"
#include "hal/store/record_bytes.hpp"

namespace ilp::postgres {

std::size_t AnswerCache::place_of(RecordType type, Question question, std::int64_t key) {
  std::uint64_t hash = static_cast<std::uint64_t>(key) * 0x9E3779B97F4A7C15U;
  hash ^= (static_cast<std::uint64_t>(type) * 4 + static_cast<std::uint64_t>(question)) * 0xC2B2AE3D27D4EB4FU;
  return static_cast<std::size_t>((hash ^ hash >> 29U) * 0x9E3779B97F4A7C15U >> 54U);
}

std::uint64_t AnswerCache::check_of(const RecordInfo& info, const Entry& entry) {
  const std::int64_t head[] = {entry.key,
                               entry.answer.count,
                               std::int64_t{entry.epoch},
                               static_cast<std::int64_t>(entry.type),
                               static_cast<std::int64_t>(entry.question),
                               entry.answer.found ? 1 : 0};
  const std::uint64_t sum = checksum64(memory_of(head));
  if (!entry.answer.found || entry.question == Question::count) return sum;
  return checksum64(std::as_bytes(std::span(entry.answer.record).first(info.bytes)), sum);
}

const AnswerCache::Answer* AnswerCache::find(const RecordInfo& info, Question question, std::int64_t key) const {
  const Entry& entry = entries_[place_of(info.type, question, key)];
  const bool is_it =
      entry.type == info.type && entry.question == question && entry.key == key && entry.epoch == epoch_of(info.type);
  return is_it && entry.check == check_of(info, entry) ? &entry.answer : nullptr;
}

AnswerCache::Entry& AnswerCache::entry_for(const RecordInfo& info, Question question, std::int64_t key) {
  Entry& entry = entries_[place_of(info.type, question, key)];
  entry.key = key;
  entry.epoch = epoch_of(info.type);
  entry.type = info.type;
  entry.question = question;
  entry.answer.count = 0;
  return entry;
}

void AnswerCache::keep(const RecordInfo& info, Question question, std::int64_t key, const void* record) {
  Entry& entry = entry_for(info, question, key);
  entry.answer.found = record != nullptr;
  if (record != nullptr) std::memcpy(entry.answer.record.data(), record, info.bytes);
  entry.check = check_of(info, entry);
}

void AnswerCache::keep_count(const RecordInfo& info, std::int64_t records) {
  Entry& entry = entry_for(info, Question::count, 0);
  entry.answer.found = true;
  entry.answer.count = records;
  entry.check = check_of(info, entry);
}

void AnswerCache::forget(RecordMask tables) {
  for (std::size_t t = 0; t < epochs_.size(); ++t) {
    if ((tables >> t & 1U) != 0) ++epochs_[t];
  }
}

void AnswerCache::forget_record(const RecordInfo& info, std::int64_t id) {
  for (Entry& entry : entries_) {
    if (entry.type != info.type || entry.epoch == 0) continue;
    const std::int64_t told = entry.answer.found ? id_of(entry.answer.record.data()) : 0;
    bool untrue = true;
    switch (entry.question) {
      case Question::get:
        untrue = entry.key == id;
        break;
      case Question::next:
        untrue = entry.key < id && (!entry.answer.found || told >= id);
        break;
      case Question::last:
        untrue = !entry.answer.found || told <= id;
        break;
      case Question::count:
        break;
    }
    if (untrue) entry.epoch = 0;
  }
}

}  // namespace ilp::postgres
