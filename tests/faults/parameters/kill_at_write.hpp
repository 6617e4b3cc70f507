// Ends a process in the middle of its work on the disk, at a place that a number names: the same in every run.
#pragma once

#include <cstdint>
#include <functional>

namespace ilp::faults {

/// The calls of this process that change a file are counted from now on. Of call number `call` (from 1) the first half
/// is carried out, if it writes, and then the process is killed. 0: it is not.
void kill_at_write(std::int64_t call);

enum class End : std::uint8_t { exited, killed, crashed };

/// Runs `boot`, which ends with _exit(), in a process of its own that is killed at its call `kill`, if that is not 0.
End run_boot(std::int64_t kill, const std::function<void()>& boot, int& status);

}  // namespace ilp::faults
