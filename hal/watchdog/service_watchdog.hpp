// Reports to the service manager's watchdog: systemd kills and restarts a service that has not reported for WatchdogSec
// (sd_notify(3), systemd.service(5)). A report is one datagram to a UNIX socket.
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

  /// `address` is the value of NOTIFY_SOCKET: a path, or an abstract name that begins with @. With a null pointer or an
  /// empty text there is no manager, and the other calls do nothing. Returns `watchdog_refused` (first value: errno) if
  /// the address is invalid or no socket can be made.
  Status open(const char* address);
  /// Reports that the service has started.
  Status ready() { return send("READY=1"); }
  /// Reports that the service works, at most once a second by `now`. The next call tries again after a failure, but
  /// only the first failure in a row is returned.
  Status kick(TimeNs now);
  /// Reports that the service ends in order.
  void stop() { static_cast<void>(send("STOPPING=1")); }

 private:
  Status send(std::string_view report);

  int socket_ = -1;
  sockaddr_un manager_{};
  socklen_t manager_size_ = 0;
  bool reported_ = false;   ///< `reported_at_` is valid
  bool failing_ = false;    ///< the latest kick() failed and was reported
  TimeNs reported_at_ = 0;  ///< time of the latest sent kick
};

}  // namespace ilp
