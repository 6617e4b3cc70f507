#include "bsp/linux/board.hpp"

#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sched.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

#include "hal/posix/file.hpp"

namespace ilp {
namespace {

std::size_t segment_bytes(bool writable) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the kernel hands addresses over as numbers
  const auto* const segments = reinterpret_cast<const ElfW(Phdr)*>(getauxval(AT_PHDR));
  const std::size_t count = getauxval(AT_PHNUM);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (segments[i].p_type == PT_LOAD && ((segments[i].p_flags & PF_W) != 0) == writable) bytes += segments[i].p_memsz;
  }
  return bytes;
}

}  // namespace

BoardState board_state() {
  BoardState state;
  const int file = ::open("/proc/sys/kernel/random/boot_id", O_RDONLY | O_CLOEXEC);
  if (file < 0) return state;
  std::uint8_t text[sizeof(state.boot) - 1];
  std::size_t bytes = 0;
  if (read_some(file, text, bytes).ok()) {
    for (std::size_t i = 0; i < bytes && text[i] > ' '; ++i) state.boot[i] = static_cast<char>(text[i]);
  }
  ::close(file);
  return state;
}

Status ask_for_real_time(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return {StatusCode::priority_refused, errno};
  if (sched_setscheduler(0, SCHED_FIFO, &wanted) != 0) return {StatusCode::priority_refused, errno};
  return {};
}

std::size_t static_bytes() {
  return segment_bytes(true);
}

std::size_t constant_bytes() {
  return segment_bytes(false);
}

}  // namespace ilp
