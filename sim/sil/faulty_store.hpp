// Wraps a store that is full during windows of time, or loses power at a given write.
#pragma once

#include <functional>

#include "hal/clock/clock.hpp"
#include "hal/store/forwarding_store.hpp"
#include "sim/sil/fault_plan.hpp"

namespace ilp::sil {

/// While the store is full, every write and erasure returns `store_full`, and the transaction can only be rolled back,
/// as on a disk without a free page. Reading works.
class FaultyStore final : public ForwardingStore {
 public:
  FaultyStore(Store& store, Clock& clock, const FaultWindow& full);

  /// Calls `cut` immediately before the given write (0: the next one), within its transaction. Erasures and commits
  /// count as writes.
  void cut_at_write(std::int64_t writes_from_now, std::function<void()> cut);
  /// Number of transactions that were refused as full.
  [[nodiscard]] std::int64_t refused() const { return refused_; }

  Status begin() override;
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;

 private:
  void meet_power_cut();
  Status admit();

  Clock& clock_;
  FaultWindow full_;
  Status doomed_;
  std::int64_t refused_ = 0;
  std::int64_t writes_until_cut_ = -1;
  std::function<void()> cut_;
};

}  // namespace ilp::sil
