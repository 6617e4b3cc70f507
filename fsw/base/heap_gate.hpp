// Flight code declares here which library's region serves the calls to malloc in a block (architecture, "Memory").
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// The libraries that call malloc in flight, each with a region of its own.
enum class HeapRegion : std::uint8_t {
  early,
  openjpeg,
  postgres,  ///< kept between the calls: a connection lives in it
  jpeg,      ///< pictures of a camera
  count
};

/// How the board serves these calls. On a host nothing is installed and the system heap serves everybody.
struct HeapGateHooks {
  void (*enter)(HeapRegion region) = nullptr;
  void (*leave)(HeapRegion region) = nullptr;
  bool (*exhausted)(HeapRegion region) = nullptr;  ///< a request has failed since the latest enter
};
void install_heap_gate(const HeapGateHooks& hooks);

/// Opens the gate for a block of code. The region is emptied on leaving, except `postgres`: nothing allocated inside
/// may be kept.
class HeapGateScope {
 public:
  explicit HeapGateScope(HeapRegion region);
  ~HeapGateScope();
  HeapGateScope(const HeapGateScope&) = delete;
  HeapGateScope& operator=(const HeapGateScope&) = delete;
  [[nodiscard]] bool exhausted() const;

 private:
  HeapRegion region_;
};

/// A request has failed since the region's gate was opened the last time.
[[nodiscard]] bool heap_region_exhausted(HeapRegion region);

/// Calls body(context) with the gate open. This is for a C library that does not survive a failed malloc: OpenJPEG then
/// crashes or answers wrongly. When the region is exhausted the call is abandoned at once, everything it had allocated
/// is released with the region, and arena_exhausted is returned; whatever body has written is then void. `body` must
/// own nothing that a destructor would have to release.
Status call_in_heap_region(HeapRegion region, void (*body)(void*), void* context);

/// Calls body(context), which abandon_heap_call() may end, and returns false if it did. The memory that `body` has
/// allocated stays: within a call in a heap region this lets the caller release it. `body` must own nothing that a
/// destructor would have to release.
bool call_abandonable(void (*body)(void*), void* context);

/// Abandons the innermost call_abandonable() or call_in_heap_region(): for the allocator of the hooks, and for a C
/// library's report of an error from which it cannot return. Returns if there is none.
void abandon_heap_call();

}  // namespace ilp
