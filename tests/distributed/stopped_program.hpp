// Stops a program where it does the most harm.
#pragma once

#include <sys/wait.h>

#include <csignal>
#include <string>
#include <thread>

#include "hal/store/sqlite/lock_file.hpp"
#include "tests/integration/running_program.hpp"

namespace ilp::test {

/// Stops the program in the middle of a transaction on this database; false when none is seen in so many looks.
[[nodiscard]] inline bool stop_in_transaction(RunningProgram& program, const std::string& store, int looks) {
  LockFile lock;
  for (int look = 0; look < looks && program.runs(); ++look) {
    std::this_thread::yield();
    if (lock.holder(store.c_str()) != program.process()) continue;
    program.send(SIGSTOP);
    // It stops a moment after the signal.
    siginfo_t stopped;
    waitid(P_PID, static_cast<id_t>(program.process()), &stopped, WSTOPPED | WEXITED | WNOWAIT);
    if (lock.holder(store.c_str()) == program.process()) return true;
    program.send(SIGCONT);
  }
  return false;
}

}  // namespace ilp::test
