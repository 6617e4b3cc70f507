// A small file beside a flight's database, NAME-guard. One process locks it, or several that share the flight; then it
// also says which of them runs which stages. It notes that the database was found damaged.
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

  /// `store_in_use` when another process holds it and does not end within two seconds. If no such file can be made
  /// nothing is locked or noted, and the result is ok: there is no disk to guard then. `io_error` (a = errno) when it
  /// is not known whether there is a note in it.
  Status take(const char* path);
  /// Locks it together with other processes that share it. `store_in_use` when a process holds it alone for two
  /// seconds.
  Status share(const char* path);
  /// Lets other processes share it from now on, after take().
  void admit_others();
  /// Reserves stages until release(), of a file that is shared: `stage_claimed` (a = number of the stage) if another
  /// process has one of them.
  Status claim(StageMask stages);
  /// Releases lock and stages. The last process removes the file unless it holds a note.
  void release();

  /// The note outlives the process.
  [[nodiscard]] bool says_damaged() const { return damaged_; }
  void note_damage();
  /// `io_error` (a = errno): the note may still be there.
  Status forget_damage();

 private:
  Status open(const char* path, bool alone);

  const char* path_ = nullptr;
  int file_ = -1;
  bool damaged_ = false;
};

}  // namespace ilp
