// The flight program in real time, beside a vehicle whose computer sends packets with its measurements.
#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <thread>

#include "fsw/navigation/vehicle_packets.hpp"
#include "hal/clock/utc.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/link/udp/udp_link.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";

/// The first images of a prepared flight, one every `interval_ms`.
std::string strip(int images, int interval_ms) {
  std::ostringstream index;
  for (int i = 0; i < images; ++i) {
    const std::string number = std::to_string(10001 + i).substr(1);
    index << i * interval_ms * ns_per_ms << " " << (plain / "images" / (number + ".pgm")).string() << "\n";
  }
  return index.str();
}

TEST(VehicleOperation, HeightsOutOfPacketsGiveTheStripItsLength) {
  const test::TemporaryFolder folder;
  for (const char* name : {"out", "outbox", "acknowledged"}) fs::create_directories(folder / name);
  test::write_file(folder / "strip.txt", strip(12, 1500));
  const SocketAddress flight = test::free_address();
  test::RunningProgram program(
      {ILP_ONBOARD, "--trap-heap", "--index", folder / "strip.txt", "--camera", test::camera_numbers(plain),
       "--database", folder / "out/flight.db", "--outbox", folder / "outbox", "--acknowledgements",
       folder / "acknowledged", "--navigation-udp", "127.0.0.1:" + std::to_string(flight.port)},
      folder / "log");
  VirtualClock no_clock;
  UdpLink link(no_clock);
  SocketAddress any;
  ASSERT_TRUE(parse_address("127.0.0.1:0", any).ok());
  ASSERT_TRUE(link.open(any, &flight).ok());
  NavigationSample sample{.height_m = 120, .height_sigma_m = 1};
  std::uint16_t count = 0;
  for (int tenth = 0; tenth < 260; ++tenth) {
    std::vector<std::uint8_t> packet(max_navigation_packet_bytes);
    std::size_t bytes = 0;
    ASSERT_TRUE(
        encode_navigation_packet(sample, utc_now(), MissionParameters{}.vehicle_apid, count++, packet, bytes).ok());
    packet.resize(bytes);
    if (tenth == 20) packet[60] ^= 1U;
    static_cast<void>(link.send(packet));  // nobody may listen yet
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(program.stop(), 0) << program.output();
  EXPECT_NE(program.output().find("heap requests after sealing: 0\n"), std::string::npos) << program.output();
  const auto frames = test::records_of<StripFrameRecord>(folder / "out");
  ASSERT_FALSE(frames.empty()) << program.output();
  EXPECT_EQ(frames[0].verdict, StripFrameVerdict::ok);
  EXPECT_GE(frames[0].heights_used, 3U);
  EXPECT_GT(frames[0].metres_per_unit, 0);
  bool reported = false;
  for (const EventRecord& event : test::records_of<EventRecord>(folder / "out")) {
    reported = reported || event.code == static_cast<std::uint16_t>(StatusCode::navigation_refused);
  }
  EXPECT_TRUE(reported) << "one packet had a wrong octet";
}

}  // namespace
}  // namespace ilp
