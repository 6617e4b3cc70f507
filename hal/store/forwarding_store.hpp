// Base class of stores that change some calls of another store.
#pragma once

#include "hal/store/store.hpp"

namespace ilp {

/// Forwards every call to another store. A derived class overrides the calls that it changes.
class ForwardingStore : public Store {
 public:
  explicit ForwardingStore(Store& inner) : inner_(inner) {}

  Status begin() override { return inner_.begin(); }
  Status commit() override { return inner_.commit(); }
  void rollback() override { inner_.rollback(); }
  Status put(const RecordInfo& info, const void* record) override { return inner_.put(info, record); }
  Status get(const RecordInfo& info, std::int64_t id, void* record) override { return inner_.get(info, id, record); }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    return inner_.next(info, after, record);
  }
  Status last(const RecordInfo& info, void* record) override { return inner_.last(info, record); }
  Status erase(const RecordInfo& info, std::int64_t id) override { return inner_.erase(info, id); }
  Status count(const RecordInfo& info, std::int64_t& records) override { return inner_.count(info, records); }
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override {
    return inner_.write_blob(info, field, id, offset, bytes);
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    return inner_.read_blob(info, field, id, offset, bytes);
  }
  Status poll(RecordMask& changed) override { return inner_.poll(changed); }
  StoreUsage usage() override { return inner_.usage(); }
  void number_from(std::int64_t keyframe_base, std::int64_t record_base) override {
    inner_.number_from(keyframe_base, record_base);
  }
  [[nodiscard]] std::int64_t id_base(RecordType type) const override { return inner_.id_base(type); }

 protected:
  ~ForwardingStore() = default;

  Store& inner_;
};

}  // namespace ilp
