// The guard of a flight's database: a small file NAME-guard beside it. One process locks the file, or several processes
// that share the flight lock it together and claim their stages in it. A note in the file states that the database was
// found damaged.
#pragma once

#include "fsw/base/status.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

class DatabaseGuard {
 public:
  DatabaseGuard() = default;
  DatabaseGuard(const DatabaseGuard&) = delete;
  DatabaseGuard& operator=(const DatabaseGuard&) = delete;
  ~DatabaseGuard() { release(); }

  /// Locks the guard of the database at `path` for this process alone. `path` outlives the lock. Returns `store_in_use`
  /// if another process does not release it within two seconds, and `io_error` (first value: errno) if it is unknown
  /// whether the file has a note. Returns ok without a lock if the disk does not allow such a file.
  Status take(const char* path);
  /// Locks the guard together with other processes. Returns `store_in_use` if a process holds it alone for two seconds;
  /// otherwise as take().
  Status share(const char* path);
  /// Lets other processes share the guard that take() has locked.
  void admit_others();
  /// Reserves stages of a shared guard until release(). Returns `stage_claimed` (first value: component number of the
  /// stage) if another process has one of them; none is reserved then. Returns `not_ready` without a lock.
  Status claim(StageMask stages);
  /// Releases lock and stages. The last process removes the file unless it has a note.
  void release();

  /// Whether the file has the note that the database is damaged. The note outlives the process.
  [[nodiscard]] bool says_damaged() const { return damaged_; }
  /// Writes the note.
  void note_damage();
  /// Removes the note. Returns `io_error` (first value: errno) if the note may still exist.
  Status forget_damage();

 private:
  Status open(const char* path, bool alone);

  const char* path_ = nullptr;
  int file_ = -1;
  bool damaged_ = false;
};

}  // namespace ilp
