// Packets of the vehicle's computer as a source of navigation samples.
#include "fsw/navigation/vehicle_packets.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "fsw/packets/crc16.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/link/udp/udp_link.hpp"
#include "tests/support/queue_link.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

using test::Octets;

NavigationSample whole_sample() {
  NavigationSample sample;
  double value = 1;
  for (const NavigationColumn& column : navigation_columns()) {
    if (column.value != nullptr) *column.value(sample) = (value += 0.5);
  }
  return sample;
}

class VehiclePacketsTest : public testing::Test {
 protected:
  static constexpr TimeNs now = 100 * ns_per_s;

  [[nodiscard]] Octets packet(TimeNs time_ns, const NavigationSample& measured = whole_sample()) const {
    Octets octets(max_navigation_packet_bytes);
    std::size_t bytes = 0;
    EXPECT_TRUE(encode_navigation_packet(measured, MissionTime(mission.mission_epoch_s).utc(time_ns),
                                         mission.vehicle_apid, 7, octets, bytes)
                    .ok());
    octets.resize(bytes);
    return octets;
  }
  static void mend_crc(Octets& octets) {
    const std::uint16_t crc = crc16(std::span(octets).first(octets.size() - 2));
    octets[octets.size() - 2] = static_cast<std::uint8_t>(crc >> 8U);
    octets[octets.size() - 1] = static_cast<std::uint8_t>(crc);
  }
  Status next() { return source.next(now, sample); }

  MissionParameters mission;
  test::QueueLink link;
  VehiclePackets source{link, mission};
  NavigationSample sample;
};

TEST_F(VehiclePacketsTest, EveryValueArrives) {
  link.up = {packet(90 * ns_per_s)};
  ASSERT_TRUE(next().ok());
  EXPECT_EQ(sample.time_ns, 90 * ns_per_s);
  NavigationSample sent = whole_sample();
  for (const NavigationColumn& column : navigation_columns()) {
    if (column.value == nullptr) continue;
    EXPECT_EQ(*column.value(sample), *column.value(sent)) << column.name;
  }
  EXPECT_STATUS(next(), not_ready);
}

// Octets that the interface control document states, written by hand.
TEST_F(VehiclePacketsTest, ThePacketIsTheOneOfTheInterfaceControlDocument) {
  NavigationSample height{.height_m = 1.0, .height_sigma_m = 0.5};
  const Octets octets = packet(0, height);
  ASSERT_EQ(octets.size(), 6U + 7 + 9 + 1 + 17 * 8 + 2);
  EXPECT_EQ((Octets{octets.begin(), octets.begin() + 9}), (Octets{0x08, 0x10, 0xC0, 0x07, 0x00, 0x9A, 0x20, 3, 25}));
  EXPECT_EQ(octets[13], 0x41) << "P-field: CDS, microseconds";
  EXPECT_EQ(octets[22], 1) << "SID";
  EXPECT_EQ((Octets{octets.begin() + 23, octets.begin() + 39}),
            (Octets{0x3F, 0xF0, 0, 0, 0, 0, 0, 0, 0x3F, 0xE0, 0, 0, 0, 0, 0, 0}));
}

TEST_F(VehiclePacketsTest, ADatagramHoldsSeveralPacketsAndOthersArePassedOver) {
  Octets others = packet(1 * ns_per_s);
  others[1] ^= 1U;  // another APID
  Octets command = packet(2 * ns_per_s);
  command[0] |= 0x10U;
  Octets report = packet(3 * ns_per_s);
  report[22] = 2;  // another SID
  mend_crc(report);
  Octets event = packet(4 * ns_per_s);
  event[7] = 5;
  mend_crc(event);
  Octets datagram;
  for (const Octets& part : {others, command, report, event, packet(5 * ns_per_s), packet(6 * ns_per_s)}) {
    datagram.insert(datagram.end(), part.begin(), part.end());
  }
  link.up = {datagram};
  ASSERT_TRUE(next().ok());
  EXPECT_EQ(sample.time_ns, 5 * ns_per_s);
  ASSERT_TRUE(next().ok());
  EXPECT_EQ(sample.time_ns, 6 * ns_per_s);
  EXPECT_STATUS(next(), not_ready);
}

TEST_F(VehiclePacketsTest, WhatIsDamagedIsNamedAndTheNextOneIsRead) {
  Octets flipped = packet(1 * ns_per_s);
  flipped[40] ^= 4U;
  Octets cut = packet(2 * ns_per_s);
  cut.resize(cut.size() - 1);
  Octets shorter = packet(3 * ns_per_s);
  shorter.resize(shorter.size() - 8);
  shorter[5] = static_cast<std::uint8_t>(shorter[5] - 8);
  mend_crc(shorter);
  link.up = {flipped, cut, shorter, {0x08}, {}, Octets(5000), packet(4 * ns_per_s)};
  EXPECT_STATUS(next(), packet_crc);
  EXPECT_STATUS(next(), packet_too_short);
  EXPECT_STATUS(next(), packet_length);
  EXPECT_STATUS(next(), packet_too_short);
  EXPECT_STATUS(next(), packet_too_short);
  EXPECT_STATUS(next(), capacity_exceeded);
  ASSERT_TRUE(next().ok());
  EXPECT_EQ(sample.time_ns, 4 * ns_per_s);
}

TEST_F(VehiclePacketsTest, TimesOfTheFutureAndTheSameTimeTwiceAreRefused) {
  link.up = {packet(now + 2 * ns_per_s), packet(now), packet(now), packet(now - 1 * ns_per_s), packet(now + ns_per_s)};
  EXPECT_STATUS(next(), time_in_future);
  EXPECT_TRUE(next().ok());
  EXPECT_STATUS(next(), time_not_monotonic);
  EXPECT_STATUS(next(), time_not_monotonic);
  EXPECT_TRUE(next().ok()) << "the vehicle's clock may be a second ahead";
}

TEST_F(VehiclePacketsTest, AnyOctetsAreReadToTheirEnd) {
  std::uint32_t state = 1;
  const auto octet = [&state] {
    state = state * 1664525U + 1013904223U;
    return static_cast<std::uint8_t>(state >> 24U);
  };
  for (int i = 0; i < 2000; ++i) {
    Octets octets = packet(i * ns_per_ms);
    for (int k = octet() % 8; k >= 0; --k) octets[octet() % octets.size()] = octet();
    if (octet() % 2 == 0) mend_crc(octets);
    link.up.push_back(octets);
  }
  int samples = 0;
  for (int i = 0; i < 8000; ++i) samples += next().ok() ? 1 : 0;
  EXPECT_STATUS(next(), not_ready);
  EXPECT_GT(samples, 0);
}

TEST_F(VehiclePacketsTest, OverUdp) {
  VirtualClock clock;
  UdpLink vehicle(clock), flight(clock);
  SocketAddress any, here;
  ASSERT_TRUE(parse_address("127.0.0.1:0", any).ok());
  ASSERT_TRUE(flight.open(any, nullptr).ok());
  ASSERT_TRUE(flight.address(here).ok());
  ASSERT_TRUE(vehicle.open(any, &here).ok());
  VehiclePackets packets(flight, mission);
  ASSERT_TRUE(vehicle.send(packet(90 * ns_per_s)).ok());
  Status status;
  for (int i = 0; i < 1000 && !(status = packets.next(now, sample)).ok(); ++i) {
  }
  ASSERT_TRUE(status.ok());
  EXPECT_EQ(sample.time_ns, 90 * ns_per_s);
}

}  // namespace
}  // namespace ilp
