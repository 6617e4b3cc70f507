// Services of Linux: facts about the board and the running binary, and real-time scheduling.
#pragma once

#include <cstddef>
#include <span>

#include "bsp/flight/boot.hpp"
#include "fsw/base/text.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// Takes those instructions of the processor into use that not every one of its architecture has.
void use_instructions_of_processor();

/// Names the boot by the kernel's boot id.
[[nodiscard]] BoardState board_state();

/// The computer's name, cut to what a record of a process holds.
[[nodiscard]] FixedText<sizeof(NodeRecord::host)> host_name();

/// Locks all memory and requests SCHED_FIFO: `priority_refused` (a = errno) if either is not permitted.
[[nodiscard]] Status ask_for_real_time(int priority);

/// Bytes of the binary's writable segments, zeroed ones included: all its static memory.
[[nodiscard]] std::size_t static_bytes();
/// Bytes of the other segments: code and constants.
[[nodiscard]] std::size_t constant_bytes();
/// These segments in memory, and data that is constant once the program has been loaded: tables of virtual functions
/// and of addresses.
[[nodiscard]] std::span<const std::span<const std::byte>> program_image();

}  // namespace ilp
