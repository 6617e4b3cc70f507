// A store as whoever keeps house sees it: what is damaged is passed over, and keeps nobody from the rest.
#pragma once

#include "hal/store/store.hpp"

namespace ilp {

/// It is not there, or cannot be had any more.
[[nodiscard]] constexpr bool is_gone(const Status& status) {
  return status.is(StatusCode::not_found) || status.is(StatusCode::record_damaged);
}

/// next() leaves damaged records out, last() answers `not_found` where the newest one is damaged. Everything else is as
/// the store behind answers.
class SoundStore final : public Store {
 public:
  explicit SoundStore(Store& store) : store_(store) {}

  Status begin() override { return store_.begin(); }
  Status commit() override { return store_.commit(); }
  void rollback() override { store_.rollback(); }
  Status put(const RecordInfo& info, const void* record) override { return store_.put(info, record); }
  Status get(const RecordInfo& info, std::int64_t id, void* record) override { return store_.get(info, id, record); }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    Status found = store_.next(info, after, record);
    for (int passed = 0; found.is(StatusCode::record_damaged) && passed < most_passed; ++passed) {
      found = store_.next(info, found.a, record);
    }
    return found;
  }
  Status last(const RecordInfo& info, void* record) override {
    const Status found = store_.last(info, record);
    return found.is(StatusCode::record_damaged) ? Status{StatusCode::not_found} : found;
  }
  Status erase(const RecordInfo& info, std::int64_t id) override { return store_.erase(info, id); }
  Status count(const RecordInfo& info, std::int64_t& records) override { return store_.count(info, records); }
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override {
    return store_.write_blob(info, field, id, offset, bytes);
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    return store_.read_blob(info, field, id, offset, bytes);
  }
  Status poll(RecordMask& changed) override { return store_.poll(changed); }
  StoreUsage usage() override { return store_.usage(); }

 private:
  static constexpr int most_passed = 1000;  ///< in one call

  Store& store_;
};

}  // namespace ilp
