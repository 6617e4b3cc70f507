#include "bsp/flight/database_guard.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"

namespace ilp {
namespace {

constexpr char damaged_word[] = "damaged\n";
/// The locks of a killed process stay until the kernel has removed it.
constexpr int most_naps = 100;
constexpr timespec nap{0, 20'000'000};

using GuardPath = FixedText<limits::max_path_bytes + 16>;

GuardPath guard_of(const char* path) {
  GuardPath name;
  name.add(path).add("-guard");
  return name;
}

bool is_empty(int file) {
  struct stat state {};
  return ::fstat(file, &state) == 0 && state.st_size == 0;
}

/// The previous owner may have removed the file meanwhile.
bool is_gone(int file) {
  struct stat state {};
  return ::fstat(file, &state) == 0 && state.st_nlink == 0;
}

/// Waits for another process for two seconds at most; false when it does not end.
bool lock(int file) {
  for (int naps = 0; ::flock(file, LOCK_EX | LOCK_NB) != 0; ++naps) {
    if (errno == EWOULDBLOCK && naps >= most_naps) return false;
    if (errno != EWOULDBLOCK && errno != EINTR) return true;  // locks are not supported here
    ::nanosleep(&nap, nullptr);
  }
  return true;
}

}  // namespace

Status DatabaseGuard::take(const char* path) {
  release();
  path_ = path;
  const GuardPath name = guard_of(path);
  if (name.overflow()) return {};
  for (int attempt = 0; attempt < 3; ++attempt) {
    const int file = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file < 0) return {};
    if (!lock(file)) {
      ::close(file);
      return StatusCode::store_in_use;
    }
    file_ = file;
    if (!is_gone(file)) break;
    ::close(file);
    file_ = -1;
  }
  damaged_ = file_ >= 0 && !is_empty(file_);
  return {};
}

void DatabaseGuard::release() {
  if (file_ < 0) return;
  if (!damaged_) ::unlink(guard_of(path_).c_str());
  ::close(file_);
  file_ = -1;
  damaged_ = false;
}

void DatabaseGuard::note_damage() {
  if (file_ < 0 || damaged_) return;
  damaged_ = true;
  static_cast<void>(::pwrite(file_, damaged_word, sizeof(damaged_word) - 1, 0) > 0 && ::fsync(file_) == 0);
}

void DatabaseGuard::forget_damage() {
  if (file_ < 0 || !damaged_) return;
  if (::ftruncate(file_, 0) == 0) damaged_ = false;
}

}  // namespace ilp
