// A small file beside a flight's database, NAME-guard. One process at a time locks it, and it notes that the database
// was found damaged.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

class DatabaseGuard {
 public:
  DatabaseGuard() = default;
  DatabaseGuard(const DatabaseGuard&) = delete;
  DatabaseGuard& operator=(const DatabaseGuard&) = delete;
  ~DatabaseGuard() { release(); }

  /// `store_in_use` when another process holds it and does not end within two seconds. If no such file can be made
  /// nothing is locked or noted, and the result is ok: there is no disk to guard then.
  Status take(const char* path);
  /// Releases the lock. The file is removed unless it holds a note.
  void release();

  /// The note outlives the process.
  [[nodiscard]] bool says_damaged() const { return damaged_; }
  void note_damage();
  void forget_damage();

 private:
  const char* path_ = nullptr;
  int file_ = -1;
  bool damaged_ = false;
};

}  // namespace ilp
