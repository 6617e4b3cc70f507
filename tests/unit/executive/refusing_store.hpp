// A store that is full when a test says so.
#pragma once

#include "hal/store/store.hpp"

namespace ilp::test {

/// Takes no record while it is full.
class RefusingStore final : public Store {
 public:
  explicit RefusingStore(Store& store) : store_(store) {}
  Status begin() override { return store_.begin(); }
  Status commit() override { return store_.commit(); }
  void rollback() override { store_.rollback(); }
  Status put(const RecordInfo& info, const void* record) override {
    return full ? Status{StatusCode::store_full} : store_.put(info, record);
  }
  Status get(const RecordInfo& info, std::int64_t id, void* record) override { return store_.get(info, id, record); }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    return store_.next(info, after, record);
  }
  Status last(const RecordInfo& info, void* record) override { return store_.last(info, record); }
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
  bool full = false;

 private:
  Store& store_;
};

}  // namespace ilp::test
