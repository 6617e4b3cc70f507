// Beside a flight's database stands a small file, NAME-guard: one process at a time has it locked, and it says when the
// database was found damaged.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

class DatabaseGuard {
 public:
  DatabaseGuard() = default;
  DatabaseGuard(const DatabaseGuard&) = delete;
  DatabaseGuard& operator=(const DatabaseGuard&) = delete;
  ~DatabaseGuard() { release(); }

  /// `store_in_use` when another process has it and does not end within two seconds. Where no such file can be made
  /// nothing is locked or noted, and that is ok: there is no disk to guard then.
  Status take(const char* path);
  /// Gives the lock back; the file goes unless it has something to say.
  void release();

  /// Outlives the process.
  [[nodiscard]] bool says_damaged() const { return damaged_; }
  void note_damage();
  void forget_damage();

 private:
  const char* path_ = nullptr;
  int file_ = -1;
  bool damaged_ = false;
};

}  // namespace ilp
