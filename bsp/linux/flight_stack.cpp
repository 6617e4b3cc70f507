#include "bsp/linux/flight_stack.hpp"

#include <pthread.h>

#include "cfg/limits.hpp"
#include "hal/posix/measured_stack.hpp"

namespace ilp {
namespace {

alignas(stack_page_bytes) std::byte stack[limits::flight_stack_bytes];

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
  const std::span<std::byte> usable = usable_stack(stack);
  error = pthread_attr_setstack(&attributes, usable.data(), usable.size());
  if (error == 0) error = pthread_create(&thread, &attributes, run, &call);
  pthread_attr_destroy(&attributes);
  return error == 0 ? pthread_join(thread, nullptr) : error;
}

}  // namespace

int call_on_flight_stack(int (*body)(void*), void* context, int& result) {
  prepare_stack(stack);
  Call call{body, context, 0};
  const int error = start_and_wait(call);
  result = call.result;
  return error;
}

std::size_t flight_stack_peak() {
  return stack_peak(stack);
}

std::size_t flight_stack_bytes() {
  return usable_stack(stack).size();
}

}  // namespace ilp
