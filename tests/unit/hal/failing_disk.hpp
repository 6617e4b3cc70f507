// A disk under SQLite that fails on command: an SQLite VFS in front of the system's own.
#pragma once

#include <sqlite3.h>

#include <cstring>
#include <functional>
#include <utility>

namespace ilp::test {

/// While one exists, every database that is opened lies on it. One at a time.
class FailingDisk {
 public:
  FailingDisk() {
    vfs_ = *sqlite3_vfs_find(nullptr);
    vfs_.pNext = nullptr;
    vfs_.zName = "failing";
    vfs_.szOsFile += static_cast<int>(sizeof(File));
    vfs_.pAppData = this;
    vfs_.xOpen = open;
    real_ = sqlite3_vfs_find(nullptr);
    sqlite3_vfs_register(&vfs_, 1);
  }
  ~FailingDisk() {
    sqlite3_vfs_unregister(&vfs_);
    // Otherwise a VFS that was registered meanwhile would be the default.
    sqlite3_vfs_register(real_, 1);
  }
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;

  /// From write number `nth` (counted from 1) on, every write answers `code`; 0 repairs the disk.
  void fail_from(int nth, int code) {
    countdown_ = nth;
    code_ = code;
  }
  [[nodiscard]] int syncs() const { return syncs_; }
  /// Every synchronisation answers `code`; SQLITE_OK repairs the disk.
  void fail_syncs(int code) { sync_code_ = code; }
  /// Is called once, while a file is being synchronised.
  void during_next_sync(std::function<void()> act) { during_next_sync_ = std::move(act); }
  [[nodiscard]] bool failed() const { return countdown_ < 0; }

 private:
  struct File {
    sqlite3_file base;
    FailingDisk* disk;
    sqlite3_io_methods methods;
    sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  };
  static File* of(sqlite3_file* file) { return reinterpret_cast<File*>(file); }

  int answer() {
    if (countdown_ == 0) return SQLITE_OK;
    if (countdown_ > 1) {
      --countdown_;
      return SQLITE_OK;
    }
    countdown_ = -1;
    return code_;
  }

  static int open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out) {
    auto* const disk = static_cast<FailingDisk*>(vfs->pAppData);
    File* const f = of(file);
    f->disk = disk;
    f->base.pMethods = nullptr;
    const int code = disk->real_->xOpen(disk->real_, name, f->real(), flags, out);
    if (f->real()->pMethods == nullptr) return code;
    sqlite3_io_methods& m = f->methods;
    std::memset(&m, 0, sizeof(m));
    m.iVersion = f->real()->pMethods->iVersion < 2 ? f->real()->pMethods->iVersion : 2;
    m.xClose = [](sqlite3_file* x) { return of(x)->real()->pMethods->xClose(of(x)->real()); };
    m.xRead = [](sqlite3_file* x, void* to, int n, sqlite3_int64 at) {
      return of(x)->real()->pMethods->xRead(of(x)->real(), to, n, at);
    };
    m.xWrite = [](sqlite3_file* x, const void* from, int n, sqlite3_int64 at) {
      const int refused = of(x)->disk->answer();
      return refused != SQLITE_OK ? refused : of(x)->real()->pMethods->xWrite(of(x)->real(), from, n, at);
    };
    m.xTruncate = [](sqlite3_file* x, sqlite3_int64 n) { return of(x)->real()->pMethods->xTruncate(of(x)->real(), n); };
    m.xSync = [](sqlite3_file* x, int how) {
      FailingDisk& on = *of(x)->disk;
      ++on.syncs_;
      if (const auto act = std::exchange(on.during_next_sync_, nullptr)) act();
      if (on.sync_code_ != SQLITE_OK) return on.sync_code_;
      return of(x)->real()->pMethods->xSync(of(x)->real(), how);
    };
    m.xFileSize = [](sqlite3_file* x, sqlite3_int64* n) {
      return of(x)->real()->pMethods->xFileSize(of(x)->real(), n);
    };
    m.xLock = [](sqlite3_file* x, int l) { return of(x)->real()->pMethods->xLock(of(x)->real(), l); };
    m.xUnlock = [](sqlite3_file* x, int l) { return of(x)->real()->pMethods->xUnlock(of(x)->real(), l); };
    m.xCheckReservedLock = [](sqlite3_file* x, int* held) {
      return of(x)->real()->pMethods->xCheckReservedLock(of(x)->real(), held);
    };
    m.xFileControl = [](sqlite3_file* x, int op, void* argument) {
      return of(x)->real()->pMethods->xFileControl(of(x)->real(), op, argument);
    };
    m.xSectorSize = [](sqlite3_file* x) { return of(x)->real()->pMethods->xSectorSize(of(x)->real()); };
    m.xDeviceCharacteristics = [](sqlite3_file* x) {
      return of(x)->real()->pMethods->xDeviceCharacteristics(of(x)->real());
    };
    m.xShmMap = [](sqlite3_file* x, int page, int size, int extend, void volatile** to) {
      return of(x)->real()->pMethods->xShmMap(of(x)->real(), page, size, extend, to);
    };
    m.xShmLock = [](sqlite3_file* x, int offset, int n, int how) {
      return of(x)->real()->pMethods->xShmLock(of(x)->real(), offset, n, how);
    };
    m.xShmBarrier = [](sqlite3_file* x) { of(x)->real()->pMethods->xShmBarrier(of(x)->real()); };
    m.xShmUnmap = [](sqlite3_file* x, int remove) { return of(x)->real()->pMethods->xShmUnmap(of(x)->real(), remove); };
    f->base.pMethods = &m;
    return code;
  }

  sqlite3_vfs vfs_{};
  sqlite3_vfs* real_ = nullptr;
  int countdown_ = 0;
  int code_ = SQLITE_OK;
  int syncs_ = 0;
  int sync_code_ = SQLITE_OK;
  std::function<void()> during_next_sync_;
};

}  // namespace ilp::test
