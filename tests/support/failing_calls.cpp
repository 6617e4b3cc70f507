#include "tests/support/failing_calls.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace ilp::test {
namespace {

CallFault fault;
std::string part;
bool armed = false;
int calls = 0;

enum class Answer { real, half, failed };

Answer answer(Call call, const char* path) {
  if (!armed || (fault.calls & static_cast<unsigned>(call)) == 0 || std::strstr(path, part.c_str()) == nullptr) {
    return Answer::real;
  }
  const int number = ++calls;
  if (number >= fault.first && number - fault.first < fault.count) {
    if (fault.ends) _exit(0);
    errno = fault.reason;
    return Answer::failed;
  }
  return fault.in_part && number == fault.first - 1 ? Answer::half : Answer::real;
}

Answer answer(Call call, int file) {
  if (!armed) return Answer::real;
  char name[64];
  char path[512];
  std::snprintf(name, sizeof(name), "/proc/self/fd/%d", file);
  const ssize_t length = ::readlink(name, path, sizeof(path) - 1);
  path[length < 0 ? 0 : length] = 0;
  return answer(call, path);
}

/// A full disk takes what needs no more room.
bool has_capacity(int file, off_t end) {
  struct stat state {};
  return armed && fault.reason == ENOSPC && ::fstat(file, &state) == 0 && end <= state.st_size;
}

ssize_t transfer(Call call, long number, int file, void* bytes, size_t size, off_t at) {
  const bool fits = call == Call::write && has_capacity(file, at + static_cast<off_t>(size));
  const Answer is = fits ? Answer::real : answer(call, file);
  if (is == Answer::failed) return fault.nothing ? 0 : -1;
  return ::syscall(number, file, bytes, is == Answer::half && size > 1 ? size / 2 : size, at);
}

int create(const char* path, int how, mode_t mode) {
  if ((how & O_CREAT) != 0 && ::access(path, F_OK) != 0 && answer(Call::create, path) == Answer::failed) return -1;
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, how, mode));
}

mode_t mode_of(int how, va_list list) {
  return (how & O_CREAT) != 0 ? static_cast<mode_t>(va_arg(list, int)) : 0;
}

int synchronise(long number, int file) {
  return answer(Call::synchronise, file) == Answer::failed ? -1 : static_cast<int>(::syscall(number, file));
}

int truncate_to(int file, off_t bytes) {
  return answer(Call::truncate, file) == Answer::failed ? -1 : static_cast<int>(::syscall(SYS_ftruncate, file, bytes));
}

int reserve(int file, off_t at, off_t bytes) {
  if (answer(Call::write, file) == Answer::failed) return fault.reason;
  return ::syscall(SYS_fallocate, file, 0, at, bytes) == 0 ? 0 : errno;
}

}  // namespace

FailingCalls::FailingCalls(const std::string& path_part, const CallFault& wanted) {
  part = path_part;
  fault = wanted;
  calls = 0;
  armed = true;
}
FailingCalls::~FailingCalls() {
  armed = false;
}
int FailingCalls::seen() const {
  return calls;
}
bool FailingCalls::failed() const {
  return calls >= fault.first;
}

bool cut_in_call(const std::string& path_part, int call, const std::function<void()>& work) {
  constexpr int done = 1;
  const pid_t child = ::fork();
  if (child == 0) {
    const FailingCalls disk(path_part, {.calls = changes, .first = call, .ends = true});
    work();
    _exit(done);
  }
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child || !WIFEXITED(status)) std::abort();
  return WEXITSTATUS(status) != done;
}

}  // namespace ilp::test

using ilp::test::Answer;
using ilp::test::answer;
using ilp::test::Call;

extern "C" {

ssize_t pread(int file, void* to, size_t size, off_t at) {
  return ilp::test::transfer(Call::read, SYS_pread64, file, to, size, at);
}
ssize_t pread64(int file, void* to, size_t size, off_t at) {
  return ilp::test::transfer(Call::read, SYS_pread64, file, to, size, at);
}
ssize_t pwrite(int file, const void* from, size_t size, off_t at) {
  return ilp::test::transfer(Call::write, SYS_pwrite64, file, const_cast<void*>(from), size, at);
}
ssize_t pwrite64(int file, const void* from, size_t size, off_t at) {
  return ilp::test::transfer(Call::write, SYS_pwrite64, file, const_cast<void*>(from), size, at);
}
int fsync(int file) {
  return ilp::test::synchronise(SYS_fsync, file);
}
int fdatasync(int file) {
  return ilp::test::synchronise(SYS_fdatasync, file);
}
int ftruncate(int file, off_t bytes) noexcept {
  return ilp::test::truncate_to(file, bytes);
}
int ftruncate64(int file, off_t bytes) noexcept {
  return ilp::test::truncate_to(file, bytes);
}
int posix_fallocate(int file, off_t at, off_t bytes) {
  return ilp::test::reserve(file, at, bytes);
}
int posix_fallocate64(int file, off_t at, off_t bytes) {
  return ilp::test::reserve(file, at, bytes);
}
int unlink(const char* path) noexcept {
  return answer(Call::remove, path) == Answer::failed ? -1
                                                      : static_cast<int>(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}
int rename(const char* from, const char* to) noexcept {
  return answer(Call::rename, from) == Answer::failed
             ? -1
             : static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int open(const char* path, int how, ...) {
  va_list list;
  va_start(list, how);
  const mode_t mode = ilp::test::mode_of(how, list);
  va_end(list);
  return ilp::test::create(path, how, mode);
}
int open64(const char* path, int how, ...) {
  va_list list;
  va_start(list, how);
  const mode_t mode = ilp::test::mode_of(how, list);
  va_end(list);
  return ilp::test::create(path, how, mode);
}

}  // extern "C"
