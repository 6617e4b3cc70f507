#include "hal/compute/shared/compute_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

constexpr int patience_s = 1;

Status address_of_path(const char* path, sockaddr_un& address) {
  address = {};
  address.sun_family = AF_UNIX;
  const std::size_t length = std::strlen(path);
  if (length == 0 || length >= sizeof(address.sun_path)) return out_of_range(Argument::path, length);
  std::memcpy(address.sun_path, path, length);
  return {};
}

const sockaddr* general_address(const sockaddr_un* address) {
  return reinterpret_cast<const sockaddr*>(address);
}

/// A message of one byte that may carry a file.
struct FileMessage {
  std::byte byte{};
  iovec part{&byte, 1};
  alignas(cmsghdr) unsigned char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};

  FileMessage() {
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof(control);
  }
};

Status send_file(int socket, int file) {
  FileMessage to_send;
  cmsghdr* const header = CMSG_FIRSTHDR(&to_send.message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(header), &file, sizeof(int));
  if (::sendmsg(socket, &to_send.message, MSG_NOSIGNAL | MSG_DONTWAIT) != 1) return {StatusCode::io_error, errno};
  return {};
}

/// How long a call waits for the other end; 0: without end.
void set_patience(int socket, int seconds) {
  const timeval time{seconds, 0};
  static_cast<void>(::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &time, sizeof(time)));
}

Status receive_file(int socket, int& file) {
  FileMessage received;
  if (::recvmsg(socket, &received.message, MSG_CMSG_CLOEXEC) != 1) return StatusCode::parse_error;
  const cmsghdr* const header = CMSG_FIRSTHDR(&received.message);
  if (header == nullptr || header->cmsg_type != SCM_RIGHTS || header->cmsg_len != CMSG_LEN(sizeof(int))) {
    return StatusCode::parse_error;
  }
  std::memcpy(&file, CMSG_DATA(header), sizeof(int));
  return {};
}

}  // namespace

Status connect_compute(const char* path, int memory, int& socket) {
  sockaddr_un address;
  ILP_TRY(address_of_path(path, address));
  socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return {StatusCode::io_error, errno};
  Status status;
  if (::connect(socket, general_address(&address), sizeof(address)) != 0) status = {StatusCode::io_error, errno};
  if (status.ok()) status = send_file(socket, memory);
  if (status.ok()) return {};
  ::close(socket);
  socket = -1;
  return status;
}

Status listen_compute(const char* path, int& listener) {
  sockaddr_un address;
  ILP_TRY(address_of_path(path, address));
  listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (listener < 0) return {StatusCode::io_error, errno};
  ::unlink(path);
  // Linux gives the file the mode of its socket.
  if (::fchmod(listener, S_IRUSR | S_IWUSR) != 0 || ::bind(listener, general_address(&address), sizeof(address)) != 0 ||
      ::listen(listener, 1) != 0) {
    const Status status{StatusCode::io_error, errno};
    ::close(listener);
    listener = -1;
    return status;
  }
  return {};
}

Status accept_compute(int listener, int& socket, int& memory) {
  socket = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
  if (socket < 0) return {StatusCode::io_error, errno};
  set_patience(socket, patience_s);
  const Status status = receive_file(socket, memory);
  set_patience(socket, 0);
  if (status.ok()) return {};
  ::close(socket);
  socket = -1;
  return status;
}

}  // namespace ilp
