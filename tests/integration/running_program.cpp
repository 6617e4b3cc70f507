#include "tests/integration/running_program.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>

namespace ilp::test {
namespace {
constexpr int patience_ms = 60'000;
constexpr int look_ms = 20;
}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& arguments, std::filesystem::path log)
    : log_(std::move(log)) {
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const int output = open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  process_ = fork();
  if (process_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
    execv(words[0], words.data());
    _exit(127);
  }
  close(output);
}

RunningProgram::~RunningProgram() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

std::string RunningProgram::output() const {
  std::ifstream in(log_);
  return {std::istreambuf_iterator<char>(in), {}};
}

bool RunningProgram::says(const std::string& text) const {
  for (int waited = 0; waited < patience_ms; waited += look_ms) {
    if (output().find(text) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(look_ms));
  }
  return false;
}

SocketAddress RunningProgram::address(const std::string& what) const {
  SocketAddress address;
  for (int waited = 0; waited < patience_ms; waited += look_ms) {
    const std::string text = output();
    const std::size_t at = text.find(what + " at ");
    const std::size_t end = at == std::string::npos ? at : text.find('\n', at);
    if (end != std::string::npos) {
      const std::size_t begin = at + what.size() + 4;
      if (parse_address(text.substr(begin, end - begin).c_str(), address).ok()) return address;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(look_ms));
  }
  return address;
}

void RunningProgram::send(int signal) const {
  if (process_ > 0) kill(process_, signal);
}

bool RunningProgram::runs() {
  int status = 0;
  if (process_ > 0 && waitpid(process_, &status, WNOHANG) == process_) {
    process_ = -1;
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  return process_ > 0;
}

int RunningProgram::wait() {
  for (int waited = 0; runs() && waited < patience_ms; waited += look_ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(look_ms));
  }
  return runs() ? -1 : status_;
}

int RunningProgram::stop() {
  send(SIGTERM);
  return wait();
}

SocketAddress free_address() {
  SocketAddress address{0x7F000001, 0};
  int socket = -1;
  if (open_socket(SocketKind::udp, address, socket).ok()) static_cast<void>(local_address(socket, address));
  close_socket(socket);
  return address;
}

}  // namespace ilp::test
