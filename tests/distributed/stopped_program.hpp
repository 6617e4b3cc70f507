// Stops a program where it does the most harm.
#pragma once

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "hal/store/sqlite/lock_file.hpp"
#include "tests/integration/running_program.hpp"

namespace ilp::test {

/// Stops the program in the middle of a transaction on this database; false when it has none within some seconds.
[[nodiscard]] inline bool stop_in_transaction(RunningProgram& program, const std::string& store) {
  LockFile lock;
  for (int attempt = 0; attempt < 100'000 && program.runs(); ++attempt) {
    std::this_thread::sleep_for(std::chrono::microseconds(50));
    if (lock.holder(store.c_str()) != program.process()) continue;
    program.send(SIGSTOP);
    // It stops a moment after the signal.
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (lock.holder(store.c_str()) == program.process()) return true;
    program.send(SIGCONT);
  }
  return false;
}

}  // namespace ilp::test
