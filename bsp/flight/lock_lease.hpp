// Limits how long a process can keep the writers' lock of a database file (docs/several-machines.md, "A lease for the
// lock").
#pragma once

#include "hal/store/forwarding_store.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {

inline constexpr int usual_lock_lease_s = 10;

/// The store of a process that is not the primary. An alarm ends the process with exit status 3 if a transaction takes
/// longer than the lease. The class uses the process's alarm (SIGALRM).
class LeasedStore final : public ForwardingStore {
 public:
  LeasedStore(Store& inner, int lease_s);

  Status begin() override;
  Status commit() override;
  void rollback() override;

 private:
  unsigned lease_s_;
};

/// Whether the latest transaction failed because another process kept the lock; false without a database (nullptr).
[[nodiscard]] inline bool is_locked(SqliteStore* database) {
  return database != nullptr && sqlite::locked_ms(database->session()) > 0;
}
/// Tries to take the lock. If another process keeps it, waits 20 ms and returns true. Must be called outside a
/// transaction.
bool wait_for_lock(SqliteStore* database);

/// For the primary: finds a process that keeps the lock for longer than the lease. If the process runs the same program
/// it belongs to this flight, because it has passed the guard of the database. It is then killed, even if it is
/// stopped.
class LockWatch {
 public:
  /// Call it often, also when the lock is free. Returns `lock_holder` (first value: process, second: 1 if it was
  /// killed) once for each process beyond the lease, else ok.
  Status look(SqliteStore& store, int lease_s);

 private:
  int holder_ = 0;             ///< process that keeps the lock; 0: none is known
  std::int64_t since_ms_ = 0;  ///< sqlite::locked_ms() when it was first seen
  bool reported_ = false;
};

}  // namespace ilp
