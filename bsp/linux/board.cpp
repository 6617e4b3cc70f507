#include "bsp/linux/board.hpp"

#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sched.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

#include "fsw/base/crc.hpp"
#include "hal/posix/file.hpp"

// NOLINTNEXTLINE(bugprone-reserved-identifier): the linker gives the beginning of the program this name
extern const ElfW(Ehdr) __ehdr_start __attribute__((visibility("hidden")));

namespace ilp {
namespace {

std::size_t segment_bytes(bool writable) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the kernel passes addresses as numbers
  const auto* const segments = reinterpret_cast<const ElfW(Phdr)*>(getauxval(AT_PHDR));
  const std::size_t count = getauxval(AT_PHNUM);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (segments[i].p_type == PT_LOAD && ((segments[i].p_flags & PF_W) != 0) == writable) bytes += segments[i].p_memsz;
  }
  return bytes;
}

constexpr std::size_t most_regions = 8;
std::span<const std::byte> image_regions[most_regions];

}  // namespace

std::span<const std::span<const std::byte>> program_image() {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the kernel passes addresses as numbers
  const auto* const segments = reinterpret_cast<const ElfW(Phdr)*>(getauxval(AT_PHDR));
  const std::size_t segment_count = getauxval(AT_PHNUM);
  const auto* const file_begin = reinterpret_cast<const std::byte*>(&__ehdr_start);
  std::size_t first_address = 0;
  for (std::size_t i = 0; i < segment_count; ++i) {
    if (segments[i].p_type == PT_LOAD && segments[i].p_offset == 0) first_address = segments[i].p_vaddr;
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < segment_count && count < most_regions; ++i) {
    const ElfW(Phdr)& segment = segments[i];
    const bool constant = segment.p_type == PT_LOAD && (segment.p_flags & (PF_W | PF_R)) == PF_R;
    if (!constant && segment.p_type != PT_GNU_RELRO) continue;
    image_regions[count++] = {file_begin + (segment.p_vaddr - first_address), segment.p_memsz};
  }
  return std::span(image_regions).first(count);
}

void use_instructions_of_processor() {
#if defined(__aarch64__)
  use_crc32c_instructions(may_have_crc32c_instructions() && (getauxval(AT_HWCAP) & HWCAP_CRC32) != 0);
#endif
}

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

FixedText<sizeof(NodeRecord::host)> host_name() {
  char name[sizeof(NodeRecord::host)] = {};
  FixedText<sizeof(NodeRecord::host)> text;
  // A name that is cut is no failure for us.
  static_cast<void>(::gethostname(name, sizeof(name) - 1));
  text.add(name);
  return text;
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
