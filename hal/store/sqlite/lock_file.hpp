// Finds the process that holds the write lock of a database with a write-ahead log. SQLite locks bytes of the log's
// index.
#pragma once

namespace ilp {

class LockFile {
 public:
  LockFile() = default;
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;
  ~LockFile() { close(); }

  /// Process id of the holder of the write lock of the database at `path`. 0: no other process holds it, or there is no
  /// index. -1: the holder has no process id here (it runs in another container).
  [[nodiscard]] int holder(const char* path);
  /// Call it only after this process has closed the database: closing any descriptor of the index releases the locks
  /// that SQLite has on it.
  void close();

 private:
  int file_ = -1;
};

}  // namespace ilp
