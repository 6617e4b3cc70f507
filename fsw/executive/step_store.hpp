// The store as components see it: a step whose memory was changed by nobody commits nothing.
#pragma once

#include "fsw/executive/component.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Asks the store behind. The first commit of a step compares, where the component says so, its cursor and state with
/// what they were before the step; what differs is a flipped bit: nothing is committed, and the answer is
/// `memory_damaged`.
class StepStore final : public Store {
 public:
  explicit StepStore(Store& store) : store_(store) {}

  void begin_step(const LastingMemory& memory, std::uint64_t state_checksum) {
    memory_ = memory;
    state_checksum_ = state_checksum;
    watching_ = memory.changes_by_commits();
    committed_ = refused_ = false;
  }
  void end_step() { watching_ = false; }
  [[nodiscard]] bool committed() const { return committed_; }
  [[nodiscard]] bool refused() const { return refused_; }

  Status begin() override { return store_.begin(); }
  Status commit() override {
    refused_ = watching_ && !committed_ && memory_.state_checksum() != state_checksum_;
    if (refused_) {
      store_.rollback();
      return StatusCode::memory_damaged;
    }
    committed_ = true;
    return store_.commit();
  }
  void rollback() override { store_.rollback(); }
  Status put(const RecordInfo& info, const void* record) override { return store_.put(info, record); }
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

 private:
  Store& store_;
  LastingMemory memory_;
  std::uint64_t state_checksum_ = 0;
  bool watching_ = false;
  bool committed_ = false;
  bool refused_ = false;
};

}  // namespace ilp
