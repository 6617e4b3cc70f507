#include "hal/compute/shared/shared_compute.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "hal/compute/shared/compute_socket.hpp"

namespace ilp {
namespace {

constexpr int pause_ms = 1;

TimeNs monotonic_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * ns_per_s + now.tv_nsec;
}

/// Takes what lies in the socket. False where the other end is closed.
bool drain(int socket) {
  std::byte updates[64];
  const ssize_t got = ::recv(socket, updates, sizeof(updates), MSG_DONTWAIT);
  return got > 0 || (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR));
}

}  // namespace

ComputeFault SharedCompute::open(const SharedComputeOptions& options) {
  leave();
  options_ = options;
  closed_ = ComputeFault::unreachable;
  if (!memory_.make(compute_header(forms_)).ok()) return closed_;
  if (!connect_compute(options.path, memory_.file(), socket_).ok()) {
    memory_.close();
    return closed_;
  }
  closed_ = ComputeFault::gone;
  return ComputeFault::none;
}

ComputeFault SharedCompute::begin(const ComputeJob& job) {
  if (socket_ < 0) return closed_;
  Place& place = places_[static_cast<std::size_t>(job.kind)];
  ++place.number;
  place.output = job.output;
  place.deadline_ns = monotonic_ns() + options_.limit_ns;
  // The layout is the flight's own: what stands in the memory about it is for the program.
  const ComputeHeader header = compute_header(forms_);
  const ComputeMailbox& layout = header.boxes[static_cast<std::size_t>(job.kind)];
  ComputeMailbox& box = memory_.box(job.kind);
  std::memcpy(memory_.at(layout.input_offset), job.input.data(), job.input.size());
  box.input_sum = compute_sum(job.input, job.kind, place.number);
  std::atomic_ref(box.asked).store(place.number, std::memory_order_release);
  const auto byte = static_cast<std::byte>(job.kind);
  const ssize_t sent = ::send(socket_, &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL);
  // A full socket is the fault of a program that does not read: it will be late.
  return sent == 1 || errno == EAGAIN || errno == EWOULDBLOCK ? ComputeFault::none : ComputeFault::gone;
}

ComputeFault SharedCompute::ask(ComputeKind kind, bool& done) {
  done = false;
  if (socket_ < 0) return closed_;
  const bool there = drain(socket_);
  const Place& place = places_[static_cast<std::size_t>(kind)];
  ComputeMailbox& box = memory_.box(kind);
  const std::uint32_t answered = std::atomic_ref(box.answered).load(std::memory_order_acquire);
  if (answered != place.number) {
    if (answered > place.number) return ComputeFault::damaged;
    if (!there) return ComputeFault::gone;
    return monotonic_ns() > place.deadline_ns ? ComputeFault::late : ComputeFault::none;
  }
  const ComputeHeader header = compute_header(forms_);
  const std::byte* const output = memory_.at(header.boxes[static_cast<std::size_t>(kind)].output_offset);
  // The copy is checked, because the memory may change at any time.
  std::memcpy(place.output.data(), output, place.output.size());
  const std::uint64_t sum = std::atomic_ref(box.output_sum).load(std::memory_order_relaxed);
  if (sum != compute_sum(place.output, kind, place.number)) return ComputeFault::damaged;
  done = true;
  return ComputeFault::none;
}

void SharedCompute::pause() {
  pollfd waiting{socket_, POLLIN, 0};
  if (socket_ < 0) return;
  ::poll(&waiting, 1, pause_ms);
}

void SharedCompute::leave() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  memory_.close();
}

}  // namespace ilp
