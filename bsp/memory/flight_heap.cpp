#include "bsp/memory/flight_heap.hpp"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/arena.hpp"

namespace ilp {
namespace {

constexpr auto region_count = static_cast<std::size_t>(HeapRegion::count);

alignas(Arena::alignment) std::byte openjpeg_bytes[limits::openjpeg_arena_bytes];
#ifdef ILP_POSTGRES
alignas(Arena::alignment) std::byte early_bytes[limits::postgres_early_heap_bytes];
alignas(Arena::alignment) std::byte postgres_bytes[limits::postgres_heap_bytes];
#else
alignas(Arena::alignment) std::byte early_bytes[limits::early_heap_bytes];
alignas(Arena::alignment) std::byte postgres_bytes[Arena::alignment];
#endif

struct Region {
  const char* name;
  std::byte* bytes;
  std::size_t size;
  Arena arena;
};

constinit Region regions[region_count] = {{"heap before sealing", early_bytes, sizeof(early_bytes), {}},
                                          {"OpenJPEG", openjpeg_bytes, sizeof(openjpeg_bytes), {}},
                                          {"PostgreSQL", postgres_bytes, sizeof(postgres_bytes), {}}};
constinit bool started = false;
constinit std::atomic<bool> sealed = false;
constinit std::atomic<std::uint64_t> traps = 0;
constinit HeapTrapMode trap_mode = HeapTrapMode::report;
constinit std::uint64_t fault_at = 0;
constinit thread_local std::uint64_t fault_countdown = 0;
constinit thread_local HeapRegion open_region = HeapRegion::early;

Arena& arena_of(HeapRegion region) {
  return regions[static_cast<std::size_t>(region)].arena;
}

void enter_region(HeapRegion region) {
  open_region = region;
  arena_of(region).clear_exhausted();
  fault_countdown = fault_at;
}

void leave_region(HeapRegion region) {
  open_region = HeapRegion::early;
  if (region != HeapRegion::postgres) arena_of(region).reset();
}

bool region_exhausted(HeapRegion region) {
  return arena_of(region).exhausted();
}

// The first request comes from the loader, before any constructor.
void start() {
  started = true;
  for (Region& region : regions) region.arena.init(region.bytes, region.size);
  install_heap_gate({enter_region, leave_region, region_exhausted});
}

char* append(char* at, const char* text) {
  while (*text != '\0') *at++ = *text++;
  return at;
}

char* append_number(char* at, std::uint64_t value, unsigned base) {
  char digits[24];
  int count = 0;
  do {
    digits[count++] = "0123456789abcdef"[value % base];
    value /= base;
  } while (value != 0);
  while (count > 0) *at++ = digits[--count];
  return at;
}

// No stdio here: it allocates.
void* trap(const char* function, std::size_t bytes, const void* caller) {
  constexpr std::uint64_t reports_max = 16;
  if (++traps <= reports_max || trap_mode == HeapTrapMode::strict) {
    char line[160];
    char* end = append(line, "heap is sealed: ");
    end = append(end, function);
    end = append(end, " of ");
    end = append_number(end, bytes, 10);
    end = append(end, " bytes from 0x");
    end = append_number(end, reinterpret_cast<std::uintptr_t>(caller), 16);
    end = append(end, "\n");
    if (::write(STDERR_FILENO, line, static_cast<std::size_t>(end - line)) < 0) errno = ENOMEM;
  }
  if (trap_mode == HeapTrapMode::strict) std::abort();
  errno = ENOMEM;
  return nullptr;
}

bool fault_due() {
  return fault_countdown != 0 && --fault_countdown == 0;
}

/// Memory that was requested before the region was opened moves into it.
void* move_into(Arena& arena, void* previous, std::size_t bytes) {
  std::size_t before = 0;
  for (const Region& region : regions) {
    if (region.arena.owns(previous)) before = region.arena.usable_size(previous);
  }
  void* const moved = arena.allocate(bytes);
  if (moved == nullptr) return nullptr;
  std::memcpy(moved, previous, before < bytes ? before : bytes);
  for (Region& region : regions) {
    if (region.arena.owns(previous)) region.arena.release(previous);
  }
  return moved;
}

// `previous` is what realloc is about to move, else nullptr.
void* request(const char* function, void* previous, std::size_t boundary, std::size_t bytes, const void* caller) {
  if (!started) start();
  if (open_region == HeapRegion::early) {
    if (sealed) return trap(function, bytes, caller);
    Arena& arena = arena_of(HeapRegion::early);
    void* early = previous != nullptr ? arena.reallocate(previous, bytes) : arena.allocate_aligned(boundary, bytes);
    if (early == nullptr) errno = ENOMEM;
    return early;
  }
  Arena& arena = arena_of(open_region);
  void* result = nullptr;
  if (fault_due()) {
    result = arena.allocate(Arena::max_bytes + 1);
  } else if (previous != nullptr && !arena.owns(previous)) {
    result = move_into(arena, previous, bytes);
  } else {
    result = previous != nullptr ? arena.reallocate(previous, bytes) : arena.allocate_aligned(boundary, bytes);
  }
  if (result == nullptr) {
    abandon_heap_call();
    errno = ENOMEM;
  }
  return result;
}

bool is_power_of_two(std::size_t value) {
  return value != 0 && (value & (value - 1)) == 0;
}

}  // namespace

void seal_heap(HeapTrapMode mode) {
  if (!started) start();
  trap_mode = mode;
  sealed = true;
}

std::uint64_t heap_trap_count() {
  return traps;
}

HeapRegionReport heap_region_report(HeapRegion region) {
  const Region& r = regions[static_cast<std::size_t>(region)];
  const ArenaStats& s = r.arena.stats();
  return {r.name, r.size, s.in_use, s.peak, s.high_water, s.requests, s.failed};
}

void set_heap_fault(std::uint64_t nth) {
  fault_at = nth;
}

}  // namespace ilp

extern "C" {

void* malloc(std::size_t bytes) {
  return ilp::request("malloc", nullptr, ilp::Arena::alignment, bytes, __builtin_return_address(0));
}

void free(void* pointer) {
  for (ilp::Region& region : ilp::regions) {
    if (region.arena.owns(pointer)) region.arena.release(pointer);
  }
}

void* calloc(std::size_t count, std::size_t bytes) {
  std::size_t total = 0;
  if (__builtin_mul_overflow(count, bytes, &total)) total = SIZE_MAX;
  void* result = ilp::request("calloc", nullptr, ilp::Arena::alignment, total, __builtin_return_address(0));
  if (result != nullptr) std::memset(result, 0, total);
  return result;
}

void* realloc(void* pointer, std::size_t bytes) {
  return ilp::request("realloc", pointer, ilp::Arena::alignment, bytes, __builtin_return_address(0));
}

int posix_memalign(void** result, std::size_t boundary, std::size_t bytes) {
  if (!ilp::is_power_of_two(boundary) || boundary % sizeof(void*) != 0) return EINVAL;
  const int saved = errno;
  void* pointer = ilp::request("posix_memalign", nullptr, boundary, bytes, __builtin_return_address(0));
  errno = saved;
  if (pointer == nullptr) return ENOMEM;
  *result = pointer;
  return 0;
}

void* aligned_alloc(std::size_t boundary, std::size_t bytes) {
  if (!ilp::is_power_of_two(boundary)) {
    errno = EINVAL;
    return nullptr;
  }
  return ilp::request("aligned_alloc", nullptr, boundary, bytes, __builtin_return_address(0));
}

void* memalign(std::size_t boundary, std::size_t bytes) {
  return aligned_alloc(boundary, bytes);
}

void* valloc(std::size_t bytes) {
  return aligned_alloc(4096, bytes);
}

void* pvalloc(std::size_t bytes) {
  return aligned_alloc(4096, (bytes + 4095) / 4096 * 4096);
}

std::size_t malloc_usable_size(void* pointer) {
  for (const ilp::Region& region : ilp::regions) {
    if (region.arena.owns(pointer)) return region.arena.usable_size(pointer);
  }
  return 0;
}

}  // extern "C"
