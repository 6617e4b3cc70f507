#include "fsw/base/heap_gate.hpp"

#include <csetjmp>

namespace ilp {
namespace {

HeapGateHooks installed;
thread_local std::jmp_buf* innermost_call = nullptr;

}  // namespace

// A function of its own, so that no variable of the caller is in a register across setjmp.
[[gnu::noinline]] bool call_abandonable(void (*body)(void*), void* context) {
  std::jmp_buf here;
  std::jmp_buf* const outer = innermost_call;
  innermost_call = &here;
  if (setjmp(here) != 0) {
    innermost_call = outer;
    return false;
  }
  body(context);
  innermost_call = outer;
  return true;
}

void install_heap_gate(const HeapGateHooks& hooks) {
  installed = hooks;
}

HeapGateScope::HeapGateScope(HeapRegion region) : region_(region) {
  if (installed.enter != nullptr) installed.enter(region_);
}

HeapGateScope::~HeapGateScope() {
  if (installed.leave != nullptr) installed.leave(region_);
}

bool heap_region_exhausted(HeapRegion region) {
  return installed.exhausted != nullptr && installed.exhausted(region);
}

bool HeapGateScope::exhausted() const {
  return installed.exhausted != nullptr && installed.exhausted(region_);
}

Status call_in_heap_region(HeapRegion region, void (*body)(void*), void* context) {
  const HeapGateScope scope(region);
  const bool finished = call_abandonable(body, context);
  if (!finished || scope.exhausted()) return {StatusCode::arena_exhausted, static_cast<std::int64_t>(region), 0};
  return {};
}

void abandon_heap_call() {
  if (innermost_call != nullptr) std::longjmp(*innermost_call, 1);
}

}  // namespace ilp
