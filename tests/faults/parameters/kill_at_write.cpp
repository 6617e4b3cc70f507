#include "tests/faults/parameters/kill_at_write.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

namespace {

std::int64_t calls_left = 0;

/// True once, in the call that is the last one.
bool is_last_call() {
  return calls_left > 0 && --calls_left == 0;
}

[[noreturn]] void end() {
  for (;;) ::kill(::getpid(), SIGKILL);
}

}  // namespace

void ilp::faults::kill_at_write(std::int64_t call) {
  calls_left = call;
}

// These stand before the C library's.
extern "C" {

ssize_t write(int file, const void* bytes, size_t size) {
  if (!is_last_call()) return ::syscall(SYS_write, file, bytes, size);
  ::syscall(SYS_write, file, bytes, size / 2);
  end();
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  if (!is_last_call()) return ::syscall(SYS_pwrite64, file, bytes, size, at);
  ::syscall(SYS_pwrite64, file, bytes, size / 2, at);
  end();
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  return pwrite64(file, bytes, size, at);
}

// The system outlives the process, so nothing need be on the disk.
int fsync(int) {
  if (is_last_call()) end();
  return 0;
}

int fdatasync(int file) {
  return fsync(file);
}

int ftruncate64(int file, off64_t size) {
  if (is_last_call()) end();
  return static_cast<int>(::syscall(SYS_ftruncate, file, size));
}

int ftruncate(int file, off_t size) {
  return ftruncate64(file, size);
}

int unlink(const char* path) {
  if (is_last_call()) end();
  return static_cast<int>(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}
}

ilp::faults::End ilp::faults::run_boot(std::int64_t kill, const std::function<void()>& boot, int& status) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    kill_at_write(kill);
    boot();
    _exit(1);
  }
  int state = 0;
  waitpid(child, &state, 0);
  status = WEXITSTATUS(state);
  if (WIFSIGNALED(state) && WTERMSIG(state) == SIGKILL && kill > 0) return End::killed;
  return WIFEXITED(state) ? End::exited : End::crashed;
}
