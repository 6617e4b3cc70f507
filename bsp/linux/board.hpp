// Facts about the board and the running program from Linux, and real-time scheduling.
#pragma once

#include <cstddef>
#include <span>

#include "bsp/flight/boot.hpp"
#include "fsw/base/text.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// Enables the use of optional processor instructions (CRC-32C on aarch64) if this processor has them.
void use_instructions_of_processor();

/// Returns the kernel's boot id; watchdog_had_bitten is not set.
[[nodiscard]] BoardState board_state();

/// Returns the computer's name, truncated to the capacity of a NodeRecord.
[[nodiscard]] FixedText<sizeof(NodeRecord::host)> host_name();

/// Locks all memory and requests SCHED_FIFO with this priority. Returns `priority_refused` (first value: errno) if
/// either is not permitted.
[[nodiscard]] Status ask_for_real_time(int priority);

/// Bytes of the program's writable segments, with those that begin as zeros: all of its static memory.
[[nodiscard]] std::size_t static_bytes();
/// Bytes of the program's other segments: code and constants.
[[nodiscard]] std::size_t constant_bytes();
/// The memory of code and constants, and of data that are constant once the program has been loaded: tables of virtual
/// functions and of addresses.
[[nodiscard]] std::span<const std::span<const std::byte>> program_image();

}  // namespace ilp
