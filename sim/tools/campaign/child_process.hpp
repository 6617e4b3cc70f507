// Programs that run beside each other, each a process group of its own.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ilp::batch {

struct ProgramCall {
  std::vector<std::string> command;  ///< the program's path and its arguments
  std::filesystem::path folder;      ///< where it runs
  std::filesystem::path log;         ///< both outputs go to the end of this file
};

/// The program inherits no open files, no blocked signals, and of the environment only where programs, libraries and
/// temporary files are; its input is empty, it leaves no core file. It dies with this process, however that ends.
/// std::runtime_error when it cannot be started.
[[nodiscard]] pid_t start_program(const ProgramCall& call);

struct ProgramEnd {
  int status = 0;  ///< of exit
  int signal = 0;  ///< that ended it; 0: none
};

/// Empty while it runs. What it has left running in its group is killed.
[[nodiscard]] std::optional<ProgramEnd> program_end(pid_t program);

/// Kills the whole group and waits for the program.
void kill_program(pid_t program);

/// "ended with status 3", "killed by signal 11 (Segmentation fault)"; empty for success.
[[nodiscard]] std::string fault_of(const ProgramEnd& end);

}  // namespace ilp::batch
