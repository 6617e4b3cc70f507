#include "bsp/flight/database_guard.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <ctime>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/sqlite/disk_file.hpp"

namespace ilp {
namespace {

constexpr char damaged_word[] = "damaged\n";
/// The locks of a killed process stay until the kernel has removed it.
constexpr int most_naps = 100;
constexpr timespec nap{0, 20'000'000};
/// Bytes of the file that stand for the stages. They are locked and never written.
constexpr off_t first_stage = 4096;

using GuardPath = FixedText<limits::max_path_bytes + 16>;

GuardPath guard_of(const char* path) {
  GuardPath name;
  name.add(path).add("-guard");
  return name;
}

Result<bool> is_empty(int file) {
  struct stat state {};
  if (::fstat(file, &state) != 0) return Status{StatusCode::io_error, errno};
  return state.st_size == 0;
}

/// Nothing can be made on such a disk, or not by us.
bool is_no_place(int reason) {
  return reason == ENOSPC || reason == EROFS || reason == EACCES || reason == EPERM;
}

/// The previous owner may have removed the file meanwhile.
bool is_gone(int file) {
  struct stat state {};
  return ::fstat(file, &state) == 0 && state.st_nlink == 0;
}

/// Waits for another process for two seconds at most; false when it does not end.
bool lock(int file, int how) {
  for (int naps = 0; ::flock(file, how | LOCK_NB) != 0; ++naps) {
    if (errno == EWOULDBLOCK && naps >= most_naps) return false;
    if (errno != EWOULDBLOCK && errno != EINTR) return true;  // locks are not supported here
    ::nanosleep(&nap, nullptr);
  }
  return true;
}

}  // namespace

Status DatabaseGuard::take(const char* path) {
  return open(path, true);
}

Status DatabaseGuard::share(const char* path) {
  return open(path, false);
}

Status DatabaseGuard::open(const char* path, bool alone) {
  release();
  path_ = path;
  const GuardPath name = guard_of(path);
  if (name.overflow()) return {};
  for (int attempt = 0; attempt < 3; ++attempt) {
    int file = -1;
    const Status opened = open_disk_file(name.c_str(), O_RDWR | O_CREAT, file);
    if (file < 0) return opened.ok() || is_no_place(static_cast<int>(opened.a)) ? Status{} : opened;
    if (!lock(file, alone ? LOCK_EX : LOCK_SH)) {
      ::close(file);
      return StatusCode::store_in_use;
    }
    file_ = file;
    if (!is_gone(file)) break;
    ::close(file);
    file_ = -1;
  }
  if (file_ < 0) return {};
  const Result<bool> empty = is_empty(file_);
  damaged_ = empty.ok() && !empty.value();
  if (!empty.ok()) release();
  return empty.status();
}

void DatabaseGuard::admit_others() {
  if (file_ >= 0) static_cast<void>(::flock(file_, LOCK_SH));
}

/// Locks of the open file, not of the process: they end with it, however it ends.
Status DatabaseGuard::claim(StageMask stages) {
  if (file_ < 0) return StatusCode::not_ready;
  for (unsigned i = 0; i < 32; ++i) {
    if ((stages >> i & 1U) == 0) continue;
    struct flock range {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    range.l_start = first_stage + static_cast<off_t>(i);
    range.l_len = 1;
    if (::fcntl(file_, F_OFD_SETLK, &range) == 0) continue;
    const int reason = errno;
    range.l_type = F_UNLCK;
    range.l_start = first_stage;
    range.l_len = 0;
    static_cast<void>(::fcntl(file_, F_OFD_SETLK, &range));
    if (reason != EAGAIN && reason != EACCES) return {StatusCode::io_error, reason};
    return {StatusCode::stage_claimed, static_cast<std::int64_t>(i) + 1};
  }
  return {};
}

void DatabaseGuard::release() {
  if (file_ < 0) return;
  const bool last = ::flock(file_, LOCK_EX | LOCK_NB) == 0;
  if (!damaged_ && last) ::unlink(guard_of(path_).c_str());
  ::close(file_);
  file_ = -1;
  damaged_ = false;
}

void DatabaseGuard::note_damage() {
  if (file_ < 0 || damaged_) return;
  damaged_ = true;
  const std::span word(reinterpret_cast<const std::uint8_t*>(damaged_word), sizeof(damaged_word) - 1);
  static_cast<void>(write_at(file_, word, 0).ok() && ::fsync(file_) == 0);
}

Status DatabaseGuard::forget_damage() {
  if (file_ < 0 || !damaged_) return {};
  if (::ftruncate(file_, 0) != 0 || ::fsync(file_) != 0) return {StatusCode::io_error, errno};
  damaged_ = false;
  return {};
}

}  // namespace ilp
