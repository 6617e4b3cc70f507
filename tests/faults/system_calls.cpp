#include "tests/faults/system_calls.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdarg>
#include <ctime>
#include <string>
#include <utility>

// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
int __real_open(const char* path, int flags, ...);
int __real_open64(const char* path, int flags, ...);
int __real_close(int file);
ssize_t __real_read(int file, void* to, size_t bytes);
ssize_t __real_write(int file, const void* from, size_t bytes);
ssize_t __real_pread(int file, void* to, size_t bytes, off_t at);
ssize_t __real_pread64(int file, void* to, size_t bytes, off_t at);
ssize_t __real_pwrite(int file, const void* from, size_t bytes, off_t at);
ssize_t __real_pwrite64(int file, const void* from, size_t bytes, off_t at);
int __real_ftruncate(int file, off_t bytes);
int __real_ftruncate64(int file, off_t bytes);
int __real_fsync(int file);
int __real_fdatasync(int file);
int __real_unlink(const char* path);
int __real_rename(const char* from, const char* to);
void* __real_mmap64(void* at, size_t bytes, int protection, int flags, int file, off_t offset);
int __real_usleep(useconds_t microseconds);
int __real_nanosleep(const timespec* time, timespec* rest);
int __real_clock_gettime(clockid_t clock, timespec* to);
int __real_posix_fallocate(int file, off_t at, off_t bytes);
int __real_statvfs(const char* path, struct statvfs* to);
}

namespace ilp::faults {
namespace {

struct OpenFile {
  bool watched = false;
  FileKind kind = FileKind::database;
};

bool watching = false;
std::string watched_folder;  ///< with a slash behind it
SystemCallHooks hooks;
std::array<OpenFile, 256> open_files;
std::int64_t free_bytes = -1;
bool sleepless = false;
std::int64_t slept_ns = 0;

/// False for a file that is none of the flight's.
bool kind_of(const char* path, FileKind& kind) {
  if (!watching || path == nullptr) return false;
  std::string name = path;
  if (name + "/" == watched_folder) {
    kind = FileKind::folder;
    return true;
  }
  if (name.rfind(watched_folder, 0) != 0) return false;
  name = name.substr(watched_folder.size());
  if (name.rfind("flight.db", 0) != 0) {
    kind = FileKind::link;
    return name.rfind("outbox", 0) == 0 || name.rfind("acknowledged", 0) == 0;
  }
  const std::string rest = name.substr(9);
  kind = rest.empty()                  ? FileKind::database
         : rest == "-wal"              ? FileKind::log
         : rest == "-shm"              ? FileKind::index
         : rest == "-sync"             ? FileKind::mark
         : rest == "-guard"            ? FileKind::guard
         : rest == "-reserve"          ? FileKind::reserve
         : rest.rfind(".keep", 0) == 0 ? FileKind::memory
                                       : FileKind::successor;
  return true;
}

OpenFile* watched(int file) {
  if (!watching || file < 0 || static_cast<std::size_t>(file) >= open_files.size()) return nullptr;
  OpenFile& found = open_files[static_cast<std::size_t>(file)];
  return found.watched ? &found : nullptr;
}

std::int64_t size_of(int file) {
  struct stat state {};
  return fstat(file, &state) == 0 ? state.st_size : 0;
}

/// Where the blocks of the file end that it has.
std::int64_t capacity_of(int file) {
  constexpr std::int64_t block_bytes = 4096;
  return (size_of(file) + block_bytes - 1) / block_bytes * block_bytes;
}

Answer judge(const SystemCall& call) {
  return hooks.judge ? hooks.judge(call) : Answer{};
}

/// Whether the model of the disk has it.
bool modelled(FileKind kind) {
  return hooks.disk != nullptr && kind != FileKind::folder && kind != FileKind::link && kind != FileKind::reserve;
}

int sleep_for(std::int64_t ns) {
  constexpr std::int64_t as_if = 100;
  slept_ns += as_if * ns;
  return 0;
}

std::size_t size_at(const char* path) {
  struct stat state {};
  return stat(path, &state) == 0 ? static_cast<std::size_t>(state.st_size) : 0;
}

std::size_t octets(std::int64_t number) {
  return static_cast<std::size_t>(std::max<std::int64_t>(number, 0));
}

/// After the call, if it is the last one of the process.
template <typename Result>
Result answer(const Answer& how, Result done) {
  if (how.dies) hooks.end();
  return done;
}

template <typename Result>
Result fail(const Answer& how) {
  if (how.dies) hooks.end();
  errno = how.error;
  return static_cast<Result>(-1);
}

using Open = int (*)(const char*, int, ...);

int open_file(Open real, const char* path, int flags, mode_t mode) {
  FileKind kind{};
  if (!kind_of(path, kind)) return real(path, flags, mode);
  struct stat state {};
  const bool makes = (flags & O_CREAT) != 0 && stat(path, &state) != 0;
  const Answer how = judge({.kind = CallKind::open, .file = kind, .grows = makes});
  if (how.error != 0) return fail<int>(how);
  const int file = real(path, flags, mode);
  if (file >= 0 && static_cast<std::size_t>(file) < open_files.size()) {
    open_files[static_cast<std::size_t>(file)] = {true, kind};
    if (modelled(kind)) hooks.disk->opened(path, file);
  }
  return answer(how, file);
}

template <typename Real>
ssize_t read_file(int file, std::size_t bytes, Real real) {
  const OpenFile* const found = watched(file);
  if (found == nullptr) return real(bytes);
  const Answer how = judge({.kind = CallKind::read, .file = found->kind, .bytes = bytes, .fits = bytes});
  if (how.error != 0) return fail<ssize_t>(how);
  return answer(how, real(std::min(bytes, how.most)));
}

template <typename Real>
ssize_t write_file(int file, std::size_t bytes, std::int64_t at, Real real) {
  const OpenFile* const found = watched(file);
  if (found == nullptr) return real(bytes);
  const std::int64_t capacity = std::max<std::int64_t>(capacity_of(file) - at, 0);
  const std::size_t fits = std::min(bytes, static_cast<std::size_t>(capacity));
  const Answer how =
      judge({.kind = CallKind::write, .file = found->kind, .grows = fits < bytes, .bytes = bytes, .fits = fits});
  if (how.error != 0) return fail<ssize_t>(how);
  const ssize_t done = real(std::min(bytes, how.most));
  if (done > 0 && modelled(found->kind)) hooks.disk->wrote(file, at, static_cast<std::size_t>(done));
  return answer(how, done);
}

template <typename Real>
int truncate_file(int file, std::int64_t bytes, Real real) {
  const OpenFile* const found = watched(file);
  if (found == nullptr) return real();
  const Answer how = judge({.kind = CallKind::truncate,
                            .file = found->kind,
                            .grows = bytes > capacity_of(file),
                            .frees = octets(size_of(file) - bytes)});
  if (how.error != 0) return fail<int>(how);
  return answer(how, real());
}

template <typename Real>
int synchronise_file(int file, Real real) {
  const OpenFile* const found = watched(file);
  if (found == nullptr) return real();
  const Answer how = judge({.kind = CallKind::sync, .file = found->kind});
  // The disk that the trials lie on is memory.
  if (hooks.disk != nullptr && found->kind == FileKind::folder && how.error == 0) hooks.disk->synchronised_folder();
  if (modelled(found->kind)) hooks.disk->synchronised(file, how.error == 0);
  if (how.error != 0) return fail<int>(how);
  return answer(how, real());
}

std::int64_t place_in(int file) {
  return lseek(file, 0, SEEK_CUR);
}

}  // namespace

const char* call_name(CallKind kind) {
  constexpr const char* names[] = {"open", "read", "write", "allocate", "truncate", "sync", "unlink", "rename", "map"};
  static_assert(std::size(names) == static_cast<std::size_t>(CallKind::kinds));
  return names[static_cast<std::size_t>(kind)];
}

const char* file_name(FileKind kind) {
  constexpr const char* names[] = {"database",           "log",     "index of the log", "mark of the log", "guard",
                                   "nonvolatile memory", "reserve", "successor",        "folder",          "link"};
  static_assert(std::size(names) == static_cast<std::size_t>(FileKind::kinds));
  return names[static_cast<std::size_t>(kind)];
}

void watch_system_calls(const std::filesystem::path& folder, SystemCallHooks with) {
  watched_folder = folder.string() + "/";
  hooks = std::move(with);
  open_files = {};
  free_bytes = -1;
  watching = true;
}

void forget_system_calls() {
  watching = false;
  hooks = {};
}

void set_capacity(std::int64_t bytes) {
  free_bytes = bytes;
}

void sleep_no_more() {
  sleepless = true;
}

}  // namespace ilp::faults

extern "C" {

int __wrap_open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const auto mode = static_cast<mode_t>((flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, int) : 0);
  va_end(rest);
  return ilp::faults::open_file(__real_open, path, flags, mode);
}

int __wrap_open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const auto mode = static_cast<mode_t>((flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, int) : 0);
  va_end(rest);
  return ilp::faults::open_file(__real_open64, path, flags, mode);
}

int __wrap_close(int file) {
  if (ilp::faults::OpenFile* const found = ilp::faults::watched(file)) found->watched = false;
  return __real_close(file);
}

ssize_t __wrap_read(int file, void* to, size_t bytes) {
  return ilp::faults::read_file(file, bytes, [&](std::size_t n) { return __real_read(file, to, n); });
}

ssize_t __wrap_pread(int file, void* to, size_t bytes, off_t at) {
  return ilp::faults::read_file(file, bytes, [&](std::size_t n) { return __real_pread(file, to, n, at); });
}

ssize_t __wrap_pread64(int file, void* to, size_t bytes, off_t at) {
  return ilp::faults::read_file(file, bytes, [&](std::size_t n) { return __real_pread64(file, to, n, at); });
}

ssize_t __wrap_write(int file, const void* from, size_t bytes) {
  const std::int64_t at = ilp::faults::watched(file) != nullptr ? ilp::faults::place_in(file) : 0;
  return ilp::faults::write_file(file, bytes, at, [&](std::size_t n) { return __real_write(file, from, n); });
}

ssize_t __wrap_pwrite(int file, const void* from, size_t bytes, off_t at) {
  return ilp::faults::write_file(file, bytes, at, [&](std::size_t n) { return __real_pwrite(file, from, n, at); });
}

ssize_t __wrap_pwrite64(int file, const void* from, size_t bytes, off_t at) {
  return ilp::faults::write_file(file, bytes, at, [&](std::size_t n) { return __real_pwrite64(file, from, n, at); });
}

int __wrap_ftruncate(int file, off_t bytes) {
  return ilp::faults::truncate_file(file, bytes, [&] { return __real_ftruncate(file, bytes); });
}

int __wrap_ftruncate64(int file, off_t bytes) {
  return ilp::faults::truncate_file(file, bytes, [&] { return __real_ftruncate64(file, bytes); });
}

int __wrap_fsync(int file) {
  return ilp::faults::synchronise_file(file, [&] { return __real_fsync(file); });
}

int __wrap_fdatasync(int file) {
  return ilp::faults::synchronise_file(file, [&] { return __real_fdatasync(file); });
}

int __wrap_unlink(const char* path) {
  using namespace ilp::faults;
  FileKind kind{};
  if (!kind_of(path, kind)) return __real_unlink(path);
  const Answer how = judge({.kind = CallKind::unlink, .file = kind, .frees = size_at(path)});
  if (how.error != 0) return fail<int>(how);
  if (modelled(kind)) hooks.disk->unlinks(path);
  return answer(how, __real_unlink(path));
}

int __wrap_rename(const char* from, const char* to) {
  using namespace ilp::faults;
  FileKind kind{};
  if (!kind_of(from, kind)) return __real_rename(from, to);
  const Answer how = judge({.kind = CallKind::rename, .file = kind});
  if (how.error != 0) return fail<int>(how);
  const int done = __real_rename(from, to);
  if (done == 0 && modelled(kind)) hooks.disk->renamed(from, to);
  return answer(how, done);
}

void* __wrap_mmap64(void* at, size_t bytes, int protection, int flags, int file, off_t offset) {
  using namespace ilp::faults;
  if (const OpenFile* const found = watched(file)) {
    const Answer how = judge({.kind = CallKind::map, .file = found->kind});
    if (how.error != 0) {
      if (how.dies) hooks.end();
      errno = how.error;
      return MAP_FAILED;
    }
  }
  return __real_mmap64(at, bytes, protection, flags, file, offset);
}

int __wrap_usleep(useconds_t microseconds) {
  return ilp::faults::sleepless ? ilp::faults::sleep_for(std::int64_t{1000} * microseconds)
                                : __real_usleep(microseconds);
}

int __wrap_nanosleep(const timespec* time, timespec* rest) {
  return ilp::faults::sleepless ? ilp::faults::sleep_for(std::int64_t{1'000'000'000} * time->tv_sec + time->tv_nsec)
                                : __real_nanosleep(time, rest);
}

int __wrap_clock_gettime(clockid_t clock, timespec* to) {
  const int done = __real_clock_gettime(clock, to);
  if (done == 0) {
    const std::int64_t ns = to->tv_nsec + ilp::faults::slept_ns;
    to->tv_sec += ns / 1'000'000'000;
    to->tv_nsec = ns % 1'000'000'000;
  }
  return done;
}

/// Answers with the number of the fault.
int __wrap_posix_fallocate(int file, off_t at, off_t bytes) {
  using namespace ilp::faults;
  if (const OpenFile* const found = watched(file)) {
    const Answer how = judge({.kind = CallKind::allocate,
                              .file = found->kind,
                              .grows = at + bytes > capacity_of(file),
                              .bytes = octets(at + bytes - capacity_of(file))});
    if (how.dies) hooks.end();
    if (how.error != 0) return how.error;
  }
  return __real_posix_fallocate(file, at, bytes);
}

int __wrap_statvfs(const char* path, struct statvfs* to) {
  const int done = __real_statvfs(path, to);
  if (done == 0 && ilp::faults::watching && ilp::faults::free_bytes >= 0) {
    to->f_bavail = static_cast<fsblkcnt_t>(ilp::faults::free_bytes) / to->f_frsize;
  }
  return done;
}
}
// NOLINTEND(bugprone-reserved-identifier)
