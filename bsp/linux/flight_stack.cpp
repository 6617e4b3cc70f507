#include "bsp/linux/flight_stack.hpp"

#include <pthread.h>
#include <sys/mman.h>

#include <cstring>

#include "cfg/limits.hpp"

namespace ilp {
namespace {

constexpr std::size_t page_bytes = 4096;
constexpr unsigned char untouched = 0xA5;

alignas(page_bytes) unsigned char stack[limits::flight_stack_bytes];

struct Call {
  int (*body)(void*);
  void* context;
  int result;
};

void* run(void* context) {
  auto& call = *static_cast<Call*>(context);
  call.result = call.body(call.context);
  return nullptr;
}

int start_and_wait(Call& call) {
  pthread_attr_t attributes;
  int error = pthread_attr_init(&attributes);
  if (error != 0) return error;
  pthread_t thread;
  error = pthread_attr_setstack(&attributes, stack + page_bytes, sizeof(stack) - page_bytes);
  if (error == 0) error = pthread_create(&thread, &attributes, run, &call);
  pthread_attr_destroy(&attributes);
  return error == 0 ? pthread_join(thread, nullptr) : error;
}

}  // namespace

int call_on_flight_stack(int (*body)(void*), void* context, int& result) {
  std::memset(stack, untouched, sizeof(stack));
  // An overflow of the stack ends the program here, before it damages other data.
  static_cast<void>(mprotect(stack, page_bytes, PROT_NONE));
  Call call{body, context, 0};
  const int error = start_and_wait(call);
  result = call.result;
  return error;
}

std::size_t flight_stack_peak() {
  std::size_t untouched_bytes = page_bytes;
  while (untouched_bytes < sizeof(stack) && stack[untouched_bytes] == untouched) ++untouched_bytes;
  return sizeof(stack) - untouched_bytes;
}

std::size_t flight_stack_bytes() {
  return sizeof(stack) - page_bytes;
}

}  // namespace ilp
