// Positions of gpsd in packets of the vehicle's computer: a recorded track, played to the real gpsd by gpsfake.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <thread>

#include "fsw/navigation/vehicle_packets.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/link/udp/udp_link.hpp"
#include "sim/tools/gps/gps_sample.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

/// A sentence of NMEA 0183 with its checksum.
std::string sentence(const std::string& text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof(end), "*%02X\r\n", sum);
  return "$" + text + end;
}

/// 5 m/s to the east at 47.5 degrees north, from 8 degrees east on, 500 m above the sea and 48 m more above the
/// ellipsoid, once a second from 2026-03-01 12:00 on.
constexpr double metres_in_a_degree = 75395;  // of longitude at 47.5 degrees, WGS 84
std::string track(int seconds) {
  std::ostringstream text;
  for (int s = 0; s < seconds; ++s) {
    char time[16], east[24];
    std::snprintf(time, sizeof(time), "1200%02d.00", s);
    std::snprintf(east, sizeof(east), "008%09.6f", 5 * s / metres_in_a_degree * 60);
    text << sentence("GPRMC," + std::string(time) + ",A,4730.000000,N," + east + ",E,9.719,90.0,010326,,,A")
         << sentence("GPGGA," + std::string(time) + ",4730.000000,N," + east + ",E,1,10,0.9,500.0,M,48.0,M,,")
         << sentence("GPGSA,A,3,01,02,03,04,05,06,07,08,09,10,,,1.5,0.9,1.2")
         << sentence("GPGST," + std::string(time) + ",2.0,1.5,1.5,0,1.5,1.5,3.0");
  }
  return text.str();
}

TEST(GpsBridge, ARecordedTrackArrivesWithItsErrors) {
  if (test::run_program({"/bin/sh", "-c", "command -v gpsfake && command -v gpsd"}).exit_status != 0) {
    GTEST_SKIP() << "gpsfake (Debian: gpsd-clients) and gpsd are not installed";
  }
  const test::TemporaryFolder folder;
  test::write_file(folder / "track.nmea", track(59));
  const SocketAddress gpsd = test::free_address();
  VirtualClock clock;
  UdpLink link(clock);
  SocketAddress any, here;
  ASSERT_TRUE(parse_address("127.0.0.1:0", any).ok());
  ASSERT_TRUE(link.open(any, nullptr).ok());
  ASSERT_TRUE(link.address(here).ok());
  // A receiver's sentences come once a second; here every sentence takes 50 ms.
  test::RunningProgram fake(
      {"/bin/sh", "-c", "exec gpsfake -1 -q -c 0.05 -P " + std::to_string(gpsd.port) + " " + (folder / "track.nmea")},
      folder / "gpsfake");
  test::RunningProgram bridge(
      {ILP_GPS, "--port", std::to_string(gpsd.port), "--to", "127.0.0.1:" + std::to_string(here.port)},
      folder / "bridge");
  MissionParameters mission;
  mission.mission_epoch_s = (4383 + 20513) * 86400.0 + 43200;  // 2026-03-01 12:00
  VehiclePackets packets(link, mission);
  int samples = 0, with_height = 0;
  for (int i = 0; i < 1200 && samples < 20; ++i) {
    NavigationSample sample;
    while (packets.next(100 * ns_per_s, sample).ok()) {
      ++samples;
      EXPECT_TRUE(plausible(sample));
      const double seconds = static_cast<double>(sample.time_ns) / 1e9;
      EXPECT_NEAR(sample.latitude_deg, 47.5, 1e-6);
      EXPECT_NEAR((sample.longitude_deg - 8) * metres_in_a_degree, 5 * seconds, 0.5);
      EXPECT_GT(sample.horizontal_sigma_m, 0.3);
      EXPECT_LT(sample.horizontal_sigma_m, 30);
      if (sample.vertical_sigma_m > 0) {
        ++with_height;
        EXPECT_NEAR(sample.elevation_m, 548, 0.5) << "above the ellipsoid";
      }
      if (sample.velocity_sigma_m_s > 0) {
        EXPECT_NEAR(sample.velocity_m_s[0], 5, 0.05);
        EXPECT_NEAR(sample.velocity_m_s[1], 0, 0.05);
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_GE(samples, 10) << bridge.output() << fake.output();
  EXPECT_GT(with_height, 0);
  fake.stop();  // and gpsd with it
}

TEST(GpsBridge, ItWaitsForGpsdAndSaysSo) {
  const test::TemporaryFolder folder;
  const SocketAddress nobody = test::free_address();
  test::RunningProgram bridge({ILP_GPS, "--port", std::to_string(nobody.port), "--to", "127.0.0.1:9"}, folder / "log");
  for (int i = 0; i < 1200 && bridge.output().empty(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(bridge.stop(), 0);
  EXPECT_NE(bridge.output().find("gpsd at 127.0.0.1:"), std::string::npos) << bridge.output();
}

gps_fix_t whole_fix() {
  gps_fix_t fix{};
  fix.time.tv_sec = 1772366400;  // 2026-03-01 12:00
  fix.time.tv_nsec = 500000000;
  fix.mode = MODE_3D;
  fix.latitude = 47.5;
  fix.longitude = 8;
  fix.eph = 4.8954;
  fix.altHAE = 548;
  fix.epv = 3.92;
  fix.speed = 5;
  fix.track = 90;
  fix.climb = -1;
  fix.eps = 0.196;
  fix.epc = 0.392;
  return fix;
}

TEST(GpsSample, ErrorsOf95PerCentBecomeSigmas) {
  NavigationSample sample;
  UtcNs utc = 0;
  ASSERT_TRUE(gps::sample_of(whole_fix(), sample, utc));
  EXPECT_EQ(utc, (std::int64_t{4383 + 20513} * 86400 + 43200) * ns_per_s + 500 * ns_per_ms);
  EXPECT_NEAR(sample.horizontal_sigma_m, 2, 1e-3);
  EXPECT_NEAR(sample.vertical_sigma_m, 2, 1e-9);
  EXPECT_EQ(sample.elevation_m, 548);
  EXPECT_NEAR(sample.velocity_m_s[0], 5, 1e-9);
  EXPECT_NEAR(sample.velocity_m_s[1], 0, 1e-9);
  EXPECT_EQ(sample.velocity_m_s[2], -1);
  EXPECT_NEAR(sample.velocity_sigma_m_s, 0.2, 1e-9) << "the larger of both";
  EXPECT_EQ(sample.height_sigma_m, 0) << "the height above the ground is unknown";
  EXPECT_EQ(sample.tilt_sigma_rad, 0);
}

TEST(GpsSample, WhatIsUnknownIsLeftOut) {
  NavigationSample sample;
  UtcNs utc = 0;
  gps_fix_t fix = whole_fix();
  fix.mode = MODE_2D;
  fix.eps = NAN;
  ASSERT_TRUE(gps::sample_of(fix, sample, utc));
  EXPECT_EQ(sample.vertical_sigma_m, 0);
  EXPECT_EQ(sample.velocity_sigma_m_s, 0);
  for (const auto& spoil : {+[](gps_fix_t& f) { f.mode = MODE_NO_FIX; }, +[](gps_fix_t& f) { f.eph = NAN; },
                            +[](gps_fix_t& f) { f.latitude = NAN; }, +[](gps_fix_t& f) { f.time.tv_sec = 0; }}) {
    fix = whole_fix();
    spoil(fix);
    EXPECT_FALSE(gps::sample_of(fix, sample, utc));
  }
}

}  // namespace
}  // namespace ilp
