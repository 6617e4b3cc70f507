// Nobody keeps the lock of the writers of a database file for ever (docs/several-machines.md, "A lease for the lock").
#pragma once

#include "hal/store/forwarding_store.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {

inline constexpr int usual_lock_lease_s = 10;

/// The store of a process that is not the primary: an alarm ends the process, with exit status 3, when a transaction is
/// not over within the lease. It needs the process's only alarm (SIGALRM).
class LeasedStore final : public ForwardingStore {
 public:
  LeasedStore(Store& inner, int lease_s);

  Status begin() override;
  Status commit() override;
  void rollback() override;

 private:
  unsigned lease_s_;
};

/// Whether the latest transaction had to give up because another process kept the lock; not without a database
/// (nullptr).
[[nodiscard]] inline bool is_locked(SqliteStore* database) {
  return database != nullptr && sqlite::locked_ms(database->session()) > 0;
}
/// Tries the lock; true, after a nap of 20 ms, while another process keeps it. Not within a transaction.
bool wait_for_lock(SqliteStore* database);

/// For the primary: names the process that keeps the lock for longer than the lease. If it runs the same program it is
/// a process of this flight, because it has passed the guard of the database: it is ended, also one that is stopped.
class LockWatch {
 public:
  /// Call it often, also when the lock is free. Returns `lock_holder` once for each process, else ok.
  Status look(SqliteStore& store, int lease_s);

 private:
  int holder_ = 0;  ///< 0: none is known
  std::int64_t since_ms_ = 0;
  bool reported_ = false;
};

}  // namespace ilp
