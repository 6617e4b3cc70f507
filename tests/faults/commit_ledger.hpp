// What a store has confirmed by a successful commit, kept outside the process that may die.
#pragma once

#include <cstdint>

#include "hal/store/forwarding_store.hpp"

namespace ilp::faults {

/// Lies in shared memory.
class CommitLedger {
 public:
  void put(const RecordInfo& info, const void* record);
  void erase(const RecordInfo& info, std::int64_t id);
  void end(bool committed);
  /// Records of successful commits that `store` does not have as they were committed; where a later transaction was not
  /// confirmed, both states are right.
  [[nodiscard]] int missing(Store& store, std::int64_t& type, std::int64_t& id) const;

 private:
  struct Entry {
    RecordType type;
    std::int64_t id;
    std::uint32_t sum, next_sum;  ///< of the fields; 0: there is no such record
    bool open;                    ///< the transaction that wrote next_sum has not ended well
    bool in_transaction;
    bool reported;  ///< a commit has confirmed it
  };
  Entry& entry(RecordType type, std::int64_t id);
  void write(RecordType type, std::int64_t id, std::uint32_t sum);

  static constexpr std::size_t most_entries = 1 << 14;
  std::size_t count_ = 0;
  Entry entries_[most_entries];
};

/// Notes in `ledger` what goes through it.
class LedgerStore final : public ForwardingStore {
 public:
  LedgerStore(Store& inner, CommitLedger& ledger) : ForwardingStore(inner), ledger_(ledger) {}
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;

 private:
  CommitLedger& ledger_;
};

}  // namespace ilp::faults
