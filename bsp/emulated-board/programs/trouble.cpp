// Disturbs the board during a flight:
//
//   trouble AT_S full FOLDER FOR_S    takes all room of the folder's disk, and releases it
//   trouble AT_S read-only            makes every disk read-only
//   trouble AT_S damage FILE          overwrites a file from its second page on
//   trouble AT_S hang PROGRAM         stops the program of this name
//
// Times count from the start. It acts once per data disk, however often the board starts with it.

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/emulated-board/programs/processes.hpp"
#include "bsp/emulated-board/programs/readiness.hpp"

namespace {

constexpr off_t page_bytes = 4096;
constexpr off_t largest_chunk = off_t{64} << 20U;

void say(const char* what, bool good) {
  std::printf("trouble: %.3f %s%s%s\n", board::uptime_s(), what, good ? "" : ": ", good ? "" : std::strerror(errno));
}

/// Fills the disk to its last block: pieces that no longer fit are halved.
bool fill_disk(int file) {
  off_t size = 0;
  for (off_t chunk = largest_chunk; chunk >= page_bytes;) {
    if (fallocate(file, 0, size, chunk) == 0) {
      size += chunk;
    } else if (errno == ENOSPC) {
      chunk /= 2;
    } else {
      return false;
    }
  }
  return fsync(file) == 0;
}

bool fill(const char* folder, double for_s) {
  char path[600];
  std::snprintf(path, sizeof(path), "%s/filler", folder);
  const int file = open(path, O_CREAT | O_WRONLY | O_CLOEXEC, 0644);
  if (file < 0) return false;
  const bool full = fill_disk(file);
  close(file);
  say("no room is left", full);
  board::sleep_until(board::uptime_s() + for_s);
  return unlink(path) == 0;
}

/// The kernel does the same by itself after an error of the disk.
bool remount_read_only() {
  const int trigger = open("/proc/sysrq-trigger", O_WRONLY | O_CLOEXEC);
  const bool good = trigger >= 0 && write(trigger, "u", 1) == 1;
  close(trigger);
  return good;
}

bool damage(const char* path) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  struct stat about {};
  if (file < 0 || fstat(file, &about) != 0) return false;
  static unsigned char noise[page_bytes];
  std::memset(noise, 0x5A, sizeof(noise));
  bool good = true;
  for (off_t at = page_bytes; at < about.st_size && good; at += page_bytes) {
    good = pwrite(file, noise, sizeof(noise), at) == static_cast<ssize_t>(sizeof(noise));
  }
  good = fsync(file) == 0 && good;
  close(file);
  return good;
}

pid_t process_of(const char* program) {
  pid_t found = 0;
  board::for_each_process([&](int process, const char* name) {
    if (std::strcmp(name, program) == 0) found = process;
  });
  errno = ESRCH;
  return found;
}

bool hang(const char* program) {
  const pid_t process = process_of(program);
  return process > 0 && kill(process, SIGSTOP) == 0;
}

bool was_made() {
  const int file = open("/data/troubled", O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0644);
  const bool before = file < 0 && errno == EEXIST;
  if (file >= 0) {
    fsync(file);
    close(file);
  }
  return before;
}

struct Trouble {
  const char* name;
  int words;
  bool (*make)(char** words);
};
constexpr Trouble troubles[] = {
    {"full", 2, [](char** words) { return fill(words[0], std::strtod(words[1], nullptr)); }},
    {"read-only", 0, [](char**) { return remount_read_only(); }},
    {"damage", 1, [](char** words) { return damage(words[0]); }},
    {"hang", 1, [](char** words) { return hang(words[0]); }},
};

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const double begin = board::uptime_s();
  for (const Trouble& trouble : troubles) {
    if (argc < 3 || std::strcmp(argv[2], trouble.name) != 0 || argc != 3 + trouble.words) continue;
    board::say_ready();
    board::sleep_until(begin + std::strtod(argv[1], nullptr));
    if (was_made()) return 0;
    const bool good = trouble.make(argv + 3);
    say(trouble.name, good);
    return good ? 0 : 1;
  }
  std::printf("usage: trouble AT_S full FOLDER FOR_S | read-only | damage FILE | hang PROGRAM\n");
  return 2;
}
