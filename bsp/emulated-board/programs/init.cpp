// Process 1 of the emulated board: mounts, loads modules, brings up the network, runs the commands of /flight/run,
// powers off.
//
//   run PROGRAM WORD...     and wait for its end; a program that ends with 3 is started again, a few times
//   with PROGRAM WORD...    runs in parallel; waits until it reports that it is ready (a byte on descriptor 3) or ends
//
// A word in double quotes may hold spaces. The line "stop" on the console ends the program of `run` by SIGTERM, and the
// commands after it are left out. Every line of its own begins with "board: ".

#include <arpa/inet.h>
#include <fcntl.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/reboot.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/emulated-board/programs/readiness.hpp"

namespace {

constexpr int ready_patience_ms = 60'000;
constexpr int end_patience_ms = 20'000;
constexpr int look_ms = 20;
constexpr std::size_t max_words = 64;
constexpr std::size_t max_beside = 8;
// Exit status of a program that requests a new start, and the number of starts that it gets.
constexpr int restart_status = 3;
constexpr int most_restarts = 3;

void say(const char* what, const char* name, bool failed) {
  std::printf("board: %.3f %s %s%s%s\n", board::uptime_s(), what, name, failed ? ": " : "",
              failed ? std::strerror(errno) : "");
}

void mount_at(const char* source, const char* folder, const char* type, unsigned long flags) {
  mkdir(folder, 0755);
  if (mount(source, folder, type, flags, nullptr) == 0) return;
  // The disk is read-only.
  const bool protected_ = errno == EACCES || errno == EROFS;
  if (!protected_ || mount(source, folder, type, flags | MS_RDONLY, nullptr) != 0) say("cannot mount", folder, true);
}

void load_module(const char* name, const char* parameters) {
  char path[600];
  std::snprintf(path, sizeof(path), "/lib/modules/%s", name);
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0 || syscall(SYS_finit_module, file, parameters, 0) != 0) say("cannot load", name, true);
  if (file >= 0) close(file);
}

/// A line per module in the order of loading: its file, then its parameters.
void load_modules() {
  std::FILE* list = std::fopen("/lib/modules/list", "r");
  if (list == nullptr) return;
  char line[512];
  while (std::fgets(line, sizeof(line), list) != nullptr) {
    line[std::strcspn(line, "\n")] = 0;
    char* parameters = std::strchr(line, ' ');
    if (parameters != nullptr) *parameters++ = 0;
    load_module(line, parameters != nullptr ? parameters : "");
  }
  std::fclose(list);
}

bool set_address(int socket, ifreq& request, unsigned long what, const char* address) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  inet_pton(AF_INET, address, &in.sin_addr);
  std::memcpy(&request.ifr_addr, &in, sizeof(in));
  return ioctl(socket, what, &request) == 0;
}

void bring_up(const char* interface, const char* address, const char* mask) {
  const int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::snprintf(request.ifr_name, sizeof(request.ifr_name), "%s", interface);
  if (ioctl(socket_, SIOCGIFFLAGS, &request) == 0) {
    const short flags = request.ifr_flags;
    bool up =
        set_address(socket_, request, SIOCSIFADDR, address) && set_address(socket_, request, SIOCSIFNETMASK, mask);
    request.ifr_flags = static_cast<short>(flags | IFF_UP | IFF_RUNNING);
    up = up && ioctl(socket_, SIOCSIFFLAGS, &request) == 0;
    if (!up) say("cannot bring up", interface, true);
  }
  close(socket_);
}

/// The disk with that serial number. The letters of disks depend on the order in which they are found.
void mount_disk(const char* serial, const char* folder, unsigned long flags) {
  for (char letter = 'a'; letter <= 'd'; ++letter) {
    char path[64], found[64] = {};
    std::snprintf(path, sizeof(path), "/sys/block/vd%c/serial", letter);
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) continue;
    const ssize_t length = read(file, found, sizeof(found) - 1);
    close(file);
    if (length <= 0 || std::strcmp(found, serial) != 0) continue;
    std::snprintf(path, sizeof(path), "/dev/vd%c", letter);
    mount_at(path, folder, "ext4", flags);
    return;
  }
}

void start_system() {
  mount_at("devtmpfs", "/dev", "devtmpfs", 0);
  const int console = open("/dev/console", O_RDWR | O_NONBLOCK);
  for (int descriptor = 0; descriptor <= 2 && console >= 0; ++descriptor) dup2(console, descriptor);
  if (console > 2) close(console);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  mount_at("proc", "/proc", "proc", 0);
  mount_at("sysfs", "/sys", "sysfs", 0);
  mount_at("tmpfs", "/tmp", "tmpfs", 0);
  load_modules();
  bring_up("lo", "127.0.0.1", "255.0.0.0");
  bring_up("eth0", "10.0.2.15", "255.255.255.0");
  mkdir("/data", 0755);
  mount_disk("data", "/data", MS_NOATIME);
  mount_disk("frames", "/frames", MS_RDONLY);
}

struct Words {
  std::array<char*, max_words + 1> word{};
  std::size_t count = 0;
};

/// Splits the line in place.
Words cut(char* line) {
  Words words;
  char* at = line;
  while (words.count < max_words) {
    at += std::strspn(at, " \n");
    if (*at == 0) break;
    const bool quoted = *at == '"';
    if (quoted) ++at;
    words.word[words.count++] = at;
    at += std::strcspn(at, quoted ? "\"" : " \n");
    if (*at == 0) break;
    *at++ = 0;
  }
  return words;
}

class Programs {
 public:
  /// Executes one line; false when no further line may follow.
  bool obey(char* line) {
    Words words = cut(line);
    if (words.count == 0 || words.word[0][0] == '#') return true;
    const bool wait = std::strcmp(words.word[0], "run") == 0;
    if (words.count < 2 || (!wait && std::strcmp(words.word[0], "with") != 0)) {
      std::printf("board: not understood: %s\n", words.word[0]);
      return true;
    }
    return wait ? run(&words.word[1]) : start_beside(&words.word[1]);
  }

  void end_all() {
    for (std::size_t i = 0; i < beside_count_; ++i) kill(beside_[i], SIGTERM);
    for (int waited = 0; waited < end_patience_ms; waited += look_ms) {
      if (waitpid(-1, nullptr, WNOHANG) < 0) return;
      usleep(1000 * look_ms);
    }
    kill(-1, SIGKILL);
  }

 private:
  static pid_t start(char* const* words, int ready) {
    std::printf("board: %.3f starts %s\n", board::uptime_s(), words[0]);
    const pid_t child = fork();
    if (child != 0) return child;
    if (ready >= 0) dup2(ready, board::ready_descriptor);
    char path[600];
    std::snprintf(path, sizeof(path), "%s%s", words[0][0] == '/' ? "" : "/bin/", words[0]);
    execv(path, words);
    say("cannot run", path, true);
    _exit(127);
  }

  bool start_beside(char* const* words) {
    int ends[2];
    if (beside_count_ == max_beside || pipe2(ends, O_CLOEXEC) != 0) return true;
    beside_[beside_count_++] = start(words, ends[1]);
    close(ends[1]);
    pollfd wait{ends[0], POLLIN, 0};
    char byte = 0;
    if (poll(&wait, 1, ready_patience_ms) <= 0 || read(ends[0], &byte, 1) != 1) {
      std::printf("board: %.3f %s is not ready\n", board::uptime_s(), words[0]);
    }
    close(ends[0]);
    return true;
  }

  /// Whether the host requests the end.
  static bool stop_is_asked() {
    pollfd wait{STDIN_FILENO, POLLIN, 0};
    if (poll(&wait, 1, look_ms) <= 0) return false;
    char line[64] = {};
    const ssize_t length = read(STDIN_FILENO, line, sizeof(line) - 1);
    if (length <= 0) usleep(1000 * look_ms);
    return length > 0 && std::strstr(line, "stop") != nullptr;
  }

  /// Returns the exit status, -1 after a signal, and whether the host requested the end.
  static int run_once(char* const* words, bool& stopped) {
    const pid_t child = start(words, -1);
    int status = 0;
    // No limit: the host decides how long a flight takes.
    while (waitpid(child, &status, WNOHANG) != child) {
      if (!stop_is_asked()) continue;
      stopped = true;
      kill(child, SIGTERM);
    }
    if (WIFSIGNALED(status)) {
      std::printf("board: %.3f %s ended by signal %d\n", board::uptime_s(), words[0], WTERMSIG(status));
      return -1;
    }
    std::printf("board: %.3f %s ended with %d\n", board::uptime_s(), words[0], WEXITSTATUS(status));
    return WEXITSTATUS(status);
  }

  static bool run(char* const* words) {
    bool stopped = false;
    for (int restarts = 0; run_once(words, stopped) == restart_status && !stopped; ++restarts) {
      if (restarts == most_restarts) {
        std::printf("board: %.3f %s is not started again\n", board::uptime_s(), words[0]);
        break;
      }
    }
    return !stopped;
  }

  std::array<pid_t, max_beside> beside_{};
  std::size_t beside_count_ = 0;
};

void carry_out_commands() {
  static Programs programs;
  std::FILE* commands = std::fopen("/flight/run", "re");
  if (commands == nullptr) return;
  char line[2048];
  while (std::fgets(line, sizeof(line), commands) != nullptr) {
    if (!programs.obey(line)) break;
  }
  std::fclose(commands);
  programs.end_all();
}

}  // namespace

int main() {
  start_system();
  std::printf("board: %.3f ready\n", board::uptime_s());
  carry_out_commands();
  sync();
  if (umount2("/data", 0) != 0 && errno != EINVAL) say("cannot unmount", "/data", true);
  std::printf("board: %.3f off\n", board::uptime_s());
  reboot(RB_POWER_OFF);
  // Process 1 must not end.
  while (true) pause();
}
