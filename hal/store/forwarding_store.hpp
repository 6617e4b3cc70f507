// A store in front of another one.
#pragma once

#include "hal/store/store.hpp"

namespace ilp {

/// Forwards every call to another store. A derived class overrides the calls that it changes.
class ForwardingStore : public Store {
 public:
  explicit ForwardingStore(Store& behind) : behind_(behind) {}

  Status begin() override { return behind_.begin(); }
  Status commit() override { return behind_.commit(); }
  void rollback() override { behind_.rollback(); }
  Status put(const RecordInfo& info, const void* record) override { return behind_.put(info, record); }
  Status get(const RecordInfo& info, std::int64_t id, void* record) override { return behind_.get(info, id, record); }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    return behind_.next(info, after, record);
  }
  Status last(const RecordInfo& info, void* record) override { return behind_.last(info, record); }
  Status erase(const RecordInfo& info, std::int64_t id) override { return behind_.erase(info, id); }
  Status count(const RecordInfo& info, std::int64_t& records) override { return behind_.count(info, records); }
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override {
    return behind_.write_blob(info, field, id, offset, bytes);
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    return behind_.read_blob(info, field, id, offset, bytes);
  }
  Status poll(RecordMask& changed) override { return behind_.poll(changed); }
  StoreUsage usage() override { return behind_.usage(); }
  void number_from(std::int64_t keyframe_base, std::int64_t record_base) override {
    behind_.number_from(keyframe_base, record_base);
  }
  [[nodiscard]] std::int64_t id_base(RecordType type) const override { return behind_.id_base(type); }

 protected:
  ~ForwardingStore() = default;

  Store& behind_;
};

}  // namespace ilp
