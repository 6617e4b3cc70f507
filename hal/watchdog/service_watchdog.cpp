#include "hal/watchdog/service_watchdog.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>

#include "fsw/base/argument.hpp"

namespace ilp {

ServiceWatchdog::~ServiceWatchdog() {
  if (socket_ >= 0) ::close(socket_);
}

Status ServiceWatchdog::open(const char* address) {
  if (address == nullptr || address[0] == '\0') return {};
  if (socket_ >= 0) return out_of_range(Argument::watchdog);
  const std::size_t length = std::strlen(address);
  if ((address[0] != '/' && address[0] != '@') || length >= sizeof(manager_.sun_path)) {
    return {StatusCode::watchdog_refused, ENAMETOOLONG};
  }
  manager_.sun_family = AF_UNIX;
  std::memcpy(manager_.sun_path, address, length);
  if (address[0] == '@') manager_.sun_path[0] = '\0';
  manager_size_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  return socket_ >= 0 ? Status{} : Status{StatusCode::watchdog_refused, errno};
}

Status ServiceWatchdog::kick(TimeNs now) {
  // The clock may have been set back.
  const bool recent = reported_ && now >= reported_at_ && now - reported_at_ < ns_per_s;
  if (recent) return {};
  const Status sent = send("WATCHDOG=1");
  if (sent.ok()) {
    reported_ = true;
    reported_at_ = now;
    failing_ = false;
    return {};
  }
  if (failing_) return {};
  failing_ = true;
  return sent;
}

Status ServiceWatchdog::send(std::string_view report) {
  if (socket_ < 0) return {};
  // A manager that is busy must not hold up the flight.
  const ssize_t sent = ::sendto(socket_, report.data(), report.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
                                reinterpret_cast<const sockaddr*>(&manager_), manager_size_);
  return sent == static_cast<ssize_t>(report.size()) ? Status{} : Status{StatusCode::watchdog_refused, errno};
}

}  // namespace ilp
