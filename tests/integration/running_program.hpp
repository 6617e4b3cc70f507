// A program that runs beside the test, and its output so far.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/posix/socket.hpp"

namespace ilp::test {

class RunningProgram {
 public:
  /// Both outputs go to the file.
  RunningProgram(const std::vector<std::string>& arguments, std::filesystem::path log);
  /// Kills it if it still runs.
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  [[nodiscard]] std::string output() const;
  /// The address that follows `what` in the output, as soon as it is there; port 0 when it does not come.
  [[nodiscard]] SocketAddress address(const std::string& what) const;
  /// Its number; -1 when it has ended.
  [[nodiscard]] int process() const { return process_; }
  void send(int signal) const;
  [[nodiscard]] bool runs();
  /// Waits for its end, a minute at most; the exit status, -1 if it was killed or does not end.
  int wait();
  /// SIGTERM; the exit status, -1 when it did not end by itself.
  int stop();

 private:
  std::filesystem::path log_;
  int process_ = -1;
  int status_ = -1;  ///< of a process that has ended
};

/// An unused port of 127.0.0.1.
[[nodiscard]] SocketAddress free_address();

}  // namespace ilp::test
