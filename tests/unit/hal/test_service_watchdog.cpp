#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <vector>

#include "hal/watchdog/service_watchdog.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

/// The service manager's end of the protocol, as sd_notify(3) has it.
class Manager {
 public:
  explicit Manager(const std::string& address) {
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    sockaddr_un own{};
    own.sun_family = AF_UNIX;
    address.copy(own.sun_path, sizeof(own.sun_path) - 1);
    if (address[0] == '@') own.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&own), size), 0) << address;
  }
  ~Manager() { ::close(socket_); }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  std::vector<std::string> received() const {
    std::vector<std::string> reports;
    std::array<char, 100> bytes{};
    for (ssize_t size = 0; (size = ::recv(socket_, bytes.data(), bytes.size(), 0)) >= 0;) {
      reports.emplace_back(bytes.data(), static_cast<std::size_t>(size));
    }
    return reports;
  }

 private:
  int socket_ = -1;
};

using Reports = std::vector<std::string>;

TEST(ServiceWatchdog, TheManagerHearsOfTheStartOfEverySecondAndOfTheEnd) {
  const test::TemporaryFolder folder;
  for (const std::string& address : {folder / "notify", std::string("@ilp-notify-") + std::to_string(::getpid())}) {
    const Manager manager(address);
    ServiceWatchdog watchdog;
    ASSERT_TRUE(watchdog.open(address.c_str()).ok()) << address;
    EXPECT_TRUE(watchdog.ready().ok());
    EXPECT_EQ(manager.received(), Reports{"READY=1"});
    for (int frame = 0; frame < 25; ++frame) EXPECT_TRUE(watchdog.kick(5 * ns_per_s + frame * ns_per_s / 10).ok());
    EXPECT_EQ(manager.received(), (Reports{"WATCHDOG=1", "WATCHDOG=1", "WATCHDOG=1"})) << "at 0, 1 and 2 s";
    EXPECT_TRUE(watchdog.kick(ns_per_s).ok());
    EXPECT_EQ(manager.received(), Reports{"WATCHDOG=1"}) << "after the clock was set back";
    watchdog.stop();
    EXPECT_EQ(manager.received(), Reports{"STOPPING=1"});
  }
}

TEST(ServiceWatchdog, WithoutAManagerNothingIsSent) {
  for (const char* none : {static_cast<const char*>(nullptr), ""}) {
    ServiceWatchdog watchdog;
    EXPECT_TRUE(watchdog.open(none).ok());
    EXPECT_TRUE(watchdog.ready().ok());
    EXPECT_TRUE(watchdog.kick(0).ok());
    watchdog.stop();
  }
}

TEST(ServiceWatchdog, AManagerThatIsGoneIsReportedOnceAndAskedAgain) {
  const test::TemporaryFolder folder;
  const std::string address = folder / "notify";
  ServiceWatchdog watchdog;
  ASSERT_TRUE(watchdog.open(address.c_str()).ok());
  const Status status = watchdog.kick(0);
  EXPECT_EQ(status.code, StatusCode::watchdog_refused);
  EXPECT_EQ(status.a, ENOENT);
  EXPECT_TRUE(watchdog.kick(1).ok());
  const Manager manager(address);
  EXPECT_TRUE(watchdog.kick(2).ok());
  EXPECT_EQ(manager.received(), Reports{"WATCHDOG=1"});
}

TEST(ServiceWatchdog, AnAddressThatNoSocketHasIsRefused) {
  for (const std::string& address : {std::string("notify"), "/" + std::string(200, 'x')}) {
    ServiceWatchdog watchdog;
    EXPECT_EQ(watchdog.open(address.c_str()).code, StatusCode::watchdog_refused) << address;
    EXPECT_TRUE(watchdog.kick(0).ok());
  }
}

}  // namespace
}  // namespace ilp
