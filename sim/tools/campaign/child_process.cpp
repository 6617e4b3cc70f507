#include "sim/tools/campaign/child_process.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace ilp::batch {
namespace {

// Above the numbers that the child gives to its own files.
constexpr int first_free = 10;

class File {
 public:
  explicit File(int number) {
    if (number < 0) return;
    number_ = fcntl(number, F_DUPFD_CLOEXEC, first_free);
    close(number);
  }
  ~File() { reset(); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  [[nodiscard]] int number() const { return number_; }
  void reset() {
    if (number_ >= 0) close(number_);
    number_ = -1;
  }

 private:
  int number_ = -1;
};

std::vector<std::string> small_environment() {
  std::vector<std::string> environment;
  for (const char* name : {"PATH", "HOME", "TMPDIR", "LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS"}) {
    if (const char* value = std::getenv(name)) environment.push_back(std::string(name) + "=" + value);
  }
  environment.emplace_back("LC_ALL=C");
  return environment;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  list.reserve(texts.size() + 1);
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

struct Start {
  pid_t parent;
  const char* folder;
  int input, log, fault;
  char** arguments;
  char** environment;
};

// Between fork and exec: only what is safe there. posix_spawn cannot ask for death with the parent.
[[noreturn]] void become(const Start& start) {
  constexpr int fault = 3;
  sigset_t none;
  sigemptyset(&none);
  struct sigaction usual = {};
  usual.sa_handler = SIG_DFL;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) sigaction(signal, &usual, nullptr);
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if (getppid() != start.parent) _exit(127);
  const bool ready = dup2(start.input, STDIN_FILENO) >= 0 && dup2(start.log, STDOUT_FILENO) >= 0 &&
                     dup2(start.log, STDERR_FILENO) >= 0 && dup2(start.fault, fault) >= 0 &&
                     fcntl(fault, F_SETFD, FD_CLOEXEC) == 0 && close_range(fault + 1, ~0U, 0) == 0 &&
                     chdir(start.folder) == 0 && sigprocmask(SIG_SETMASK, &none, nullptr) == 0;
  if (ready) execve(start.arguments[0], start.arguments, start.environment);
  const int error = errno;
  if (write(fault, &error, sizeof(error)) < 0) _exit(126);
  _exit(127);
}

[[noreturn]] void refuse(const ProgramCall& call, int error) {
  throw std::runtime_error("cannot start " + call.command.front() + ": " + std::strerror(error));
}

}  // namespace

pid_t start_program(const ProgramCall& call) {
  std::vector<std::string> words = call.command, environment = small_environment();
  const std::vector<char*> arguments = pointers(words), variables = pointers(environment);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) refuse(call, errno);
  File read_end(ends[0]), write_end(ends[1]);
  const File input(open("/dev/null", O_RDONLY | O_CLOEXEC));
  const File log(open(call.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (read_end.number() < 0 || write_end.number() < 0 || input.number() < 0) refuse(call, EMFILE);
  if (log.number() < 0) throw std::runtime_error("cannot write " + call.log.string());
  const std::string folder = call.folder.string();
  std::vector<char*> argument_list = arguments, variable_list = variables;
  const Start start{getpid(),           folder.c_str(),       input.number(),      log.number(),
                    write_end.number(), argument_list.data(), variable_list.data()};
  const pid_t child = fork();
  if (child < 0) refuse(call, errno);
  if (child == 0) become(start);
  setpgid(child, child);
  write_end.reset();
  int error = 0;
  ssize_t got = 0;
  do {
    got = read(read_end.number(), &error, sizeof(error));
  } while (got < 0 && errno == EINTR);
  if (got != 0) {
    kill_program(child);
    refuse(call, got == static_cast<ssize_t>(sizeof(error)) ? error : EIO);
  }
  return child;
}

std::optional<ProgramEnd> program_end(pid_t program) {
  siginfo_t info{};
  // The group is killed before its number can go to somebody else.
  if (waitid(P_PID, static_cast<id_t>(program), &info, WEXITED | WNOHANG | WNOWAIT) != 0) {
    if (errno == EINTR) return {};
    throw std::runtime_error("lost a program that was started: " + std::string(std::strerror(errno)));
  }
  if (info.si_pid == 0) return {};
  kill(-program, SIGKILL);
  int status = 0;
  while (waitpid(program, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return ProgramEnd{0, WTERMSIG(status)};
  return ProgramEnd{WEXITSTATUS(status), 0};
}

void kill_program(pid_t program) {
  kill(-program, SIGKILL);
  kill(program, SIGKILL);
  while (waitpid(program, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::string fault_of(const ProgramEnd& end) {
  if (end.signal != 0) {
    const char* name = sigdescr_np(end.signal);
    return "killed by signal " + std::to_string(end.signal) + " (" + (name == nullptr ? "unknown" : name) + ")";
  }
  return end.status == 0 ? "" : "ended with status " + std::to_string(end.status);
}

}  // namespace ilp::batch
