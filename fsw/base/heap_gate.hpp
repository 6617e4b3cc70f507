// Flight code states by these calls which memory region serves malloc in a block of code (architecture, "Memory").
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// The libraries that call malloc in flight, each with a region of its own.
enum class HeapRegion : std::uint8_t {
  early,  ///< requests before the heap is sealed at the start
  openjpeg,
  postgres,  ///< keeps its content between the calls, because it holds a connection
  jpeg,      ///< pictures of a camera
  count
};

/// The board's functions that switch the region. On a host none are installed, and the system heap serves all requests.
struct HeapGateHooks {
  void (*enter)(HeapRegion region) = nullptr;
  void (*leave)(HeapRegion region) = nullptr;
  bool (*exhausted)(HeapRegion region) = nullptr;  ///< a request has failed since the latest enter
};
void install_heap_gate(const HeapGateHooks& hooks);

/// While the object exists, `region` serves malloc. Its destructor empties the region, except `postgres`, so that no
/// memory that was allocated meanwhile may be kept.
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

/// A request has failed since the latest HeapGateScope of this region began.
[[nodiscard]] bool heap_region_exhausted(HeapRegion region);

/// Calls body(context) while `region` serves malloc. This is for a C library that does not survive a failed malloc,
/// such as OpenJPEG. When the region is exhausted the call ends at once, everything that it had allocated is released
/// with the region, and `arena_exhausted` is returned; what `body` has written is then invalid. `body` must own nothing
/// that a destructor would have to release.
Status call_in_heap_region(HeapRegion region, void (*body)(void*), void* context);

/// Calls body(context). Returns false if abandon_heap_call() has ended the call. Memory that `body` has allocated stays
/// allocated, so that the caller can release it. `body` must own nothing that a destructor would have to release.
bool call_abandonable(void (*body)(void*), void* context);

/// Ends the innermost call_abandonable() or call_in_heap_region(). The allocator of the hooks calls it, and the error
/// handler of a C library that must not return. If there is no such call it does nothing.
void abandon_heap_call();

}  // namespace ilp
