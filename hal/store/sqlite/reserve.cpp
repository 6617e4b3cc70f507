#include "hal/store/sqlite/reserve.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/sqlite/disk_file.hpp"

namespace ilp {
namespace {

using Path = FixedText<limits::max_path_bytes + 16>;

Path reserve_of(const char* database) {
  Path path;
  path.add(database).add("-reserve");
  return path;
}

}  // namespace

Status make_reserve(const char* database, std::int64_t bytes) {
  const Path path = reserve_of(database);
  if (path.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  if (reserved_bytes(database) >= bytes) return {};
  struct statvfs disk {};
  const bool known = ::statvfs(database, &disk) == 0;
  if (known && static_cast<std::int64_t>(disk.f_bavail) * static_cast<std::int64_t>(disk.f_frsize) < bytes) {
    return {StatusCode::store_full, bytes};
  }
  int file = -1;
  ILP_TRY(open_disk_file(path.c_str(), O_RDWR | O_CREAT, file));
  if (file < 0) return {StatusCode::io_error, ENOENT};
  int reason = EINTR;
  for (int attempt = 0; attempt < disk_attempts && reason == EINTR; ++attempt) {
    reason = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
  }
  ::close(file);
  if (reason == 0) return {};
  // A part of it would only take room.
  ::unlink(path.c_str());
  return reason == ENOSPC ? Status{StatusCode::store_full, bytes} : Status{StatusCode::io_error, reason};
}

bool release_reserve(const char* database) {
  const Path path = reserve_of(database);
  return !path.overflow() && ::unlink(path.c_str()) == 0;
}

std::int64_t reserved_bytes(const char* database) {
  const Path path = reserve_of(database);
  struct stat state {};
  return !path.overflow() && ::stat(path.c_str(), &state) == 0 ? static_cast<std::int64_t>(state.st_size) : 0;
}

}  // namespace ilp
