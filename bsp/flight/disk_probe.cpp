#include "bsp/flight/disk_probe.hpp"

#include <pthread.h>

#include <csignal>
#include <ctime>

namespace ilp {
int DiskProbe::begin(const char* path, std::int64_t free_bytes, std::span<std::byte> stack, TimeNs interval) {
  path_ = path;
  free_bytes_ = free_bytes;
  interval_ns_ = interval;
  prepare_stack(stack);
  pthread_attr_t attributes;
  int error = pthread_attr_init(&attributes);
  if (error != 0) return error;
  const std::span<std::byte> usable = usable_stack(stack);
  error = pthread_attr_setstack(&attributes, usable.data(), usable.size());
  if (error == 0) error = pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  // Signals are for the flight's thread.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_t thread;
  if (error == 0) error = pthread_create(&thread, &attributes, enter, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  return error;
}

void* DiskProbe::enter(void* probe) {
  static_cast<DiskProbe*>(probe)->probe();
  return nullptr;
}

void DiskProbe::probe() {
  // It ends with the process.
  for (;;) {
    const TimeNs pause = interval_ns_ << (2 * count_memory_copies(path_));
    const timespec nap{static_cast<time_t>(pause / ns_per_s), static_cast<long>(pause % ns_per_s)};
    ::nanosleep(&nap, nullptr);
    if (!found() && try_disk(path_, free_bytes_).ok()) found_.store(true, std::memory_order_release);
  }
}

}  // namespace ilp
