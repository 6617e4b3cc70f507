// Who holds the lock of the writers of a database in a write-ahead log: SQLite locks bytes of the log's index.
#pragma once

namespace ilp {

class LockFile {
 public:
  LockFile() = default;
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;
  ~LockFile() { close(); }

  /// The process that holds the lock of the database at `path`, by its number; 0: no other process does, or there is no
  /// such file; -1: a process without a number in this part of the system (another container).
  [[nodiscard]] int holder(const char* path);
  /// Call it when this process has closed the database, and not before: closing any descriptor of the file ends the
  /// locks that SQLite has on it.
  void close();

 private:
  int file_ = -1;
};

}  // namespace ilp
