// The store through which components write, which refuses the commit of a step whose memory has a flipped bit.
#pragma once

#include "fsw/executive/component.hpp"
#include "hal/store/forwarding_store.hpp"

namespace ilp {

/// If a component declares that its cursor and state change only after a commit (LastingMemory::changed_by_commits),
/// the first commit of a step compares their checksum with that before the step. A difference means that a bit has
/// flipped: the transaction is rolled back, and the commit returns `memory_damaged`.
class StepStore final : public ForwardingStore {
 public:
  using ForwardingStore::ForwardingStore;

  void begin_step(const LastingMemory& memory, std::uint64_t state_checksum) {
    memory_ = memory;
    state_checksum_ = state_checksum;
    watching_ = memory.changes_by_commits();
    committed_ = refused_ = false;
  }
  void end_step() { watching_ = false; }
  [[nodiscard]] bool committed() const { return committed_; }
  [[nodiscard]] bool refused() const { return refused_; }

  Status commit() override {
    refused_ = watching_ && !committed_ && memory_.state_checksum() != state_checksum_;
    if (refused_) {
      inner_.rollback();
      return StatusCode::memory_damaged;
    }
    committed_ = true;
    return inner_.commit();
  }

 private:
  LastingMemory memory_;
  std::uint64_t state_checksum_ = 0;
  bool watching_ = false;
  bool committed_ = false;
  bool refused_ = false;
};

}  // namespace ilp
