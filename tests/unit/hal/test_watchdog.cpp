#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/watchdog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "hal/watchdog/linux_watchdog.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

/// A device as the kernel's API describes it.
struct FakeDevice {
  bool present = true;
  int shortest_s = 2, longest_s = 600;
  int timeout_s = 60;
  int boot_status = 0;
  bool broken = false;
  std::string opened;
  std::string written;
  int closed = 0;
};
FakeDevice device;

int fail(int error) {
  errno = error;
  return -1;
}

int control(int file, unsigned long request, int* value) {
  EXPECT_EQ(file, 7);
  if (request == WDIOC_GETBOOTSTATUS) {
    *value = device.boot_status;
    return 0;
  }
  if (request == WDIOC_SETTIMEOUT) {
    if (*value < device.shortest_s || *value > device.longest_s) return fail(EINVAL);
    device.timeout_s = *value;
    return 0;
  }
  if (request == WDIOC_GETTIMEOUT) {
    *value = device.timeout_s;
    return 0;
  }
  return fail(ENOTTY);
}

constexpr WatchdogCalls fake_calls{
    [](const char* path) {
      device.opened = path;
      return device.present ? 7 : fail(ENOENT);
    },
    control,
    [](int, const void* bytes, std::size_t size) -> std::ptrdiff_t {
      if (device.broken) return fail(EIO);
      device.written.append(static_cast<const char*>(bytes), size);
      return static_cast<std::ptrdiff_t>(size);
    },
    [](int) {
      ++device.closed;
      return 0;
    },
};

class WatchdogTest : public testing::Test {
 protected:
  void SetUp() override { device = {}; }
  static WatchdogOptions options(const char* text) {
    WatchdogOptions o;
    EXPECT_TRUE(parse_watchdog(text, o)) << text;
    return o;
  }
  LinuxWatchdog watchdog{fake_calls};
};

TEST_F(WatchdogTest, IsArmedWithItsTimeoutKickedAndDisarmed) {
  ASSERT_TRUE(watchdog.open(options("/dev/watchdog0:12")).ok());
  EXPECT_EQ(device.opened, "/dev/watchdog0");
  EXPECT_EQ(device.timeout_s, 12);
  EXPECT_EQ(watchdog.timeout_s(), 12);
  EXPECT_FALSE(watchdog.bitten());
  EXPECT_TRUE(watchdog.kick().ok());
  EXPECT_TRUE(watchdog.kick().ok());
  EXPECT_EQ(device.written, std::string(2, '\0')) << "no octet may be the one that disarms";
  watchdog.stop();
  EXPECT_EQ(device.written.back(), 'V');
  EXPECT_EQ(device.closed, 1);
  EXPECT_TRUE(watchdog.kick().ok());
  EXPECT_EQ(device.written.size(), 3U) << "it is closed";
}

TEST_F(WatchdogTest, ADeathIsNoOrderedEnd) {
  {
    LinuxWatchdog dying(fake_calls);
    ASSERT_TRUE(dying.open(options("/dev/watchdog")).ok());
  }
  EXPECT_EQ(device.written.find('V'), std::string::npos);
}

TEST_F(WatchdogTest, TellsThatItHasBitten) {
  device.boot_status = WDIOF_CARDRESET | WDIOF_OVERHEAT;
  ASSERT_TRUE(watchdog.open(options("/dev/watchdog")).ok());
  EXPECT_TRUE(watchdog.bitten());
  LinuxWatchdog other(fake_calls);
  device.boot_status = WDIOF_OVERHEAT;
  ASSERT_TRUE(other.open(options("/dev/watchdog")).ok());
  EXPECT_FALSE(other.bitten());
}

TEST_F(WatchdogTest, WithoutADeviceTheFlightGoesOn) {
  device.present = false;
  const Status status = watchdog.open(options("/dev/watchdog:9"));
  EXPECT_EQ(status.code, StatusCode::watchdog_refused);
  EXPECT_EQ(status.a, ENOENT);
  EXPECT_EQ(status.b, 9);
  EXPECT_TRUE(watchdog.kick().ok());
  watchdog.stop();
  EXPECT_EQ(device.written, "");
}

TEST_F(WatchdogTest, ATimeoutThatTheDriverRefusesLeavesItArmedWithItsOwn) {
  const Status status = watchdog.open(options("/dev/watchdog:1"));
  EXPECT_EQ(status.code, StatusCode::watchdog_refused);
  EXPECT_EQ(status.a, EINVAL);
  EXPECT_EQ(status.b, 1);
  EXPECT_EQ(watchdog.timeout_s(), 60);
  EXPECT_EQ(device.closed, 0);
  EXPECT_TRUE(watchdog.kick().ok());
  EXPECT_EQ(device.written.size(), 1U) << "otherwise it would bite a healthy flight";
}

TEST_F(WatchdogTest, AKickThatFailsIsToldOnceAndTriedAgain) {
  ASSERT_TRUE(watchdog.open(options("/dev/watchdog:9")).ok());
  device.broken = true;
  const Status status = watchdog.kick();
  EXPECT_EQ(status.code, StatusCode::watchdog_refused);
  EXPECT_EQ(status.a, EIO);
  EXPECT_TRUE(watchdog.kick().ok());
  device.broken = false;
  EXPECT_TRUE(watchdog.kick().ok());
  EXPECT_EQ(device.written.size(), 1U);
  device.broken = true;
  EXPECT_FALSE(watchdog.kick().ok()) << "it had worked again: this is news";
}

TEST_F(WatchdogTest, WhatIsNoWatchdogIsSaidToBeNone) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  LinuxWatchdog real;
  const Status status = real.open(options((path + ":5").c_str()));
  EXPECT_EQ(status.code, StatusCode::watchdog_refused);
  EXPECT_EQ(status.a, ENOTTY);
  EXPECT_TRUE(real.kick().ok());
  real.stop();
  char written[8] = {};
  EXPECT_EQ(::read(reader, written, sizeof(written)), 2);
  EXPECT_EQ(written[0], '\0');
  EXPECT_EQ(written[1], 'V');
  ::close(reader);
  LinuxWatchdog none;
  EXPECT_EQ(none.open(options((folder / "nothing").c_str())).a, ENOENT);
}

TEST(WatchdogOption, DeviceAndSeconds) {
  WatchdogOptions o;
  EXPECT_TRUE(parse_watchdog("/dev/watchdog", o));
  EXPECT_STREQ(o.device, "/dev/watchdog");
  EXPECT_EQ(o.timeout_s, 30);
  EXPECT_TRUE(parse_watchdog("/dev/watchdog1:86400", o));
  EXPECT_STREQ(o.device, "/dev/watchdog1");
  EXPECT_EQ(o.timeout_s, 86400);
  for (const char* bad : {"", ":5", "/dev/watchdog:", "/dev/watchdog:0", "/dev/watchdog:86401", "/dev/watchdog:5s",
                          "/dev/watchdog:-5", "/dev/watchdog:999999999999"}) {
    EXPECT_FALSE(parse_watchdog(bad, o)) << bad;
  }
  EXPECT_FALSE(parse_watchdog(std::string(limits::max_path_bytes, 'x').c_str(), o));
}

}  // namespace
}  // namespace ilp
