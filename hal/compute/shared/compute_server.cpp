#include "hal/compute/shared/compute_server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>

#include "hal/compute/shared/compute_socket.hpp"

namespace ilp {

ComputeServer::~ComputeServer() {
  leave();
  if (listener_ >= 0) ::close(listener_);
}

Status ComputeServer::listen(const char* path) {
  return listen_compute(path, listener_);
}

Status ComputeServer::accept() {
  leave();
  int file = -1;
  ILP_TRY(accept_compute(listener_, socket_, file));
  const Status mapped = memory_.map(file, header_);
  ::close(file);
  if (!mapped.ok()) leave();
  return mapped;
}

Status ComputeServer::next(ComputeJob& job) {
  for (;;) {  // bound: what arrives; each turn waits for an octet
    std::byte byte{};
    const ssize_t got = ::recv(socket_, &byte, 1, 0);
    if (got == 0) return StatusCode::end_of_stream;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return {StatusCode::io_error, errno};
    const auto kind = static_cast<ComputeKind>(byte);
    if (kind >= ComputeKind::count) continue;
    const ComputeMailbox& layout = header_.boxes[static_cast<std::size_t>(kind)];
    ComputeMailbox& box = memory_.box(kind);
    number_ = std::atomic_ref(box.asked).load(std::memory_order_acquire);
    job = {kind,
           {memory_.at(layout.input_offset), layout.input_bytes},
           {memory_.at(layout.output_offset), layout.output_bytes}};
    if (number_ != box.answered && box.input_sum == compute_sum(job.input, kind, number_)) return {};
  }
}

Status ComputeServer::answer(const ComputeJob& job) {
  ComputeMailbox& box = memory_.box(job.kind);
  box.output_sum = compute_sum(job.output, job.kind, number_);
  std::atomic_ref(box.answered).store(number_, std::memory_order_release);
  const auto byte = static_cast<std::byte>(job.kind);
  return ::send(socket_, &byte, 1, MSG_NOSIGNAL) == 1 ? Status{} : Status{StatusCode::io_error, errno};
}

void ComputeServer::leave() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  memory_.close();
}

}  // namespace ilp
