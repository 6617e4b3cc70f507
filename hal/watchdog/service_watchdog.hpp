// The watchdog of the service manager: systemd kills and starts again a service that has not reported for WatchdogSec
// (sd_notify(3), systemd.service(5)). The protocol is one datagram per report to a UNIX socket.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <string_view>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

class ServiceWatchdog {
 public:
  ServiceWatchdog() = default;
  ServiceWatchdog(const ServiceWatchdog&) = delete;
  ServiceWatchdog& operator=(const ServiceWatchdog&) = delete;
  ~ServiceWatchdog();

  /// Takes the manager's socket, the value of NOTIFY_SOCKET: a path, or an abstract name that begins with @. Null or
  /// empty means that there is no manager, and the other calls do nothing. `watchdog_refused` (a = errno).
  Status open(const char* address);
  /// The service has started.
  Status ready() { return send("READY=1"); }
  /// The service works: reported at most once in a second of `now`. A failure is returned once, and tried again.
  Status kick(TimeNs now);
  /// The service ends in order.
  void stop() { static_cast<void>(send("STOPPING=1")); }

 private:
  Status send(std::string_view report);

  int socket_ = -1;
  sockaddr_un manager_{};
  socklen_t manager_size_ = 0;
  bool reported_ = false;
  bool failing_ = false;
  TimeNs reported_at_ = 0;
};

}  // namespace ilp
