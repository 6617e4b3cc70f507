// What the router lets in, to whom it goes, and how much it lets out.
#include "fsw/packets/packet_router.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "hal/clock/virtual_clock.hpp"
#include "tests/support/hex.hpp"
#include "tests/support/loopback_link.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Written by another implementation of the standard.
const Bytes ping = from_hex("18efc00000062f1101000190eb");
const Bytes wrapped_pdu = from_hex("07fdc000001b300012110001000500020000000048656c6c6f2c2067726f756e642e");
const Bytes bare_pdu(wrapped_pdu.begin() + 6, wrapped_pdu.end());

class PacketRouterTest : public testing::Test {
 protected:
  void use_two_links() { router_ = std::make_unique<PacketRouter>(&one_->board(), &two_->board(), clock_, mission_); }
  void ground_sends(const Bytes& bytes) { EXPECT_OK(one_->ground().send(bytes)); }
  std::vector<Bytes> received(Channel channel) {
    std::vector<Bytes> packets;
    Bytes buffer(limits::max_packet_bytes);
    std::size_t size = 0;
    while (router_->receive(channel, buffer, size).ok())
      packets.emplace_back(buffer.begin(), buffer.begin() + long(size));
    return packets;
  }
  static std::vector<Bytes> received(PacketLink& link) {
    std::vector<Bytes> packets;
    Bytes buffer(limits::max_packet_bytes);
    std::size_t size = 0;
    while (link.receive(buffer, size).ok()) packets.emplace_back(buffer.begin(), buffer.begin() + long(size));
    return packets;
  }
  std::size_t sent_within(TimeNs time, Channel channel, const Bytes& packet) {
    std::size_t bytes = 0;
    for (const TimeNs end = clock_.now() + time; clock_.now() < end;
         clock_.sleep_until(clock_.now() + 100 * ns_per_ms)) {
      while (router_->send(channel, packet).ok()) {
      }
      for (const Bytes& received_packet : received(one_->ground())) bytes += received_packet.size();
    }
    return bytes;
  }

  VirtualClock clock_;
  MissionParameters mission_;
  std::unique_ptr<LoopbackLink> one_ = std::make_unique<LoopbackLink>(clock_, LoopbackFaults{});
  std::unique_ptr<LoopbackLink> two_ = std::make_unique<LoopbackLink>(clock_, LoopbackFaults{});
  std::unique_ptr<PacketRouter> router_ = std::make_unique<PacketRouter>(&one_->board(), nullptr, clock_, mission_);
};

TEST_F(PacketRouterTest, OneDatagramHoldsPacketsForBothChannels) {
  ground_sends(ping + wrapped_pdu + ping);
  EXPECT_OK(router_->pump());
  EXPECT_EQ(received(Channel::commands), (std::vector<Bytes>{ping, ping}));
  EXPECT_EQ(received(Channel::files), std::vector<Bytes>{bare_pdu});
  EXPECT_EQ(router_->counts().received, 3U);
  EXPECT_EQ(router_->counts().malformed, 0U);
}

TEST_F(PacketRouterTest, PdusComeBareOverALinkOfTheirOwnAndGoOutOverIt) {
  use_two_links();
  EXPECT_OK(two_->ground().send(bare_pdu));
  EXPECT_OK(router_->pump());
  EXPECT_EQ(received(Channel::files), std::vector<Bytes>{bare_pdu});
  EXPECT_OK(router_->send(Channel::files, bare_pdu));
  EXPECT_EQ(received(two_->ground()), std::vector<Bytes>{bare_pdu});
  EXPECT_TRUE(received(one_->ground()).empty());
}

TEST_F(PacketRouterTest, PdusAreWrappedAsAnotherImplementationWrapsThem) {
  EXPECT_OK(router_->send(Channel::files, bare_pdu));
  EXPECT_OK(router_->send(Channel::files, bare_pdu));
  const std::vector<Bytes> packets = received(one_->ground());
  ASSERT_EQ(packets.size(), 2U);
  EXPECT_EQ(packets[0], wrapped_pdu);
  EXPECT_EQ(packets[1][3], 1) << "sequence count";
}

TEST_F(PacketRouterTest, APacketCutShortIsStillHandedOverToBeAnswered) {
  const Bytes cut(ping.begin(), ping.end() - 4);
  ground_sends(ping + cut);
  EXPECT_OK(router_->pump());
  EXPECT_EQ(received(Channel::commands), (std::vector<Bytes>{ping, cut}));
  EXPECT_EQ(router_->counts().malformed, 1U);
}

TEST_F(PacketRouterTest, WhatIsNoTelecommandIsCountedAndGone) {
  ground_sends(from_hex("38efc02500062f110100010947"));  // version 1
  ground_sends(from_hex("08efc02600062f110100013e75"));  // telemetry
  ground_sends(from_hex("1fffc02600062f110100013e75"));  // idle
  ground_sends(from_hex("18ef"));
  ground_sends({});
  EXPECT_OK(router_->pump());
  EXPECT_TRUE(received(Channel::commands).empty());
  EXPECT_TRUE(received(Channel::files).empty());
  EXPECT_EQ(router_->counts().malformed, 3U);
  EXPECT_EQ(router_->counts().unknown_apid, 1U);
  EXPECT_EQ(router_->counts().received, 0U);
}

TEST_F(PacketRouterTest, TelecommandsOfAnotherApidAreCountedAndHandedOverToBeRejected) {
  ground_sends(from_hex("18eec00000062f1101000190eb"));
  EXPECT_OK(router_->pump());
  EXPECT_EQ(router_->counts().unknown_apid, 1U);
  EXPECT_EQ(received(Channel::commands).size(), 1U);
}

TEST_F(PacketRouterTest, TheApidIsASetting) {
  mission_.apid = 0xEE;
  ground_sends(ping);
  EXPECT_OK(router_->pump());
  EXPECT_EQ(router_->counts().unknown_apid, 1U);
}

TEST_F(PacketRouterTest, ABufferThatIsTooSmallGetsTheBeginningOnly) {
  ground_sends(ping);
  EXPECT_OK(router_->pump());
  Bytes small(6);
  std::size_t size = 0;
  EXPECT_STATUS(router_->receive(Channel::commands, small, size), capacity_exceeded);
  EXPECT_EQ(size, ping.size());
  EXPECT_EQ(small, Bytes(ping.begin(), ping.begin() + 6));
  EXPECT_STATUS(router_->receive(Channel::commands, small, size), not_ready);
}

TEST_F(PacketRouterTest, OutOfContactNothingGoesInOrOut) {
  mission_.pass_period_s = 100;
  mission_.pass_length_s = 10;
  ground_sends(ping);
  clock_.sleep_until(50 * ns_per_s);
  EXPECT_FALSE(router_->contact());
  EXPECT_OK(router_->pump());
  EXPECT_EQ(router_->counts().dropped, 1U);
  EXPECT_STATUS(router_->send(Channel::commands, ping), not_ready);
  clock_.sleep_until(100 * ns_per_s);
  EXPECT_OK(router_->pump());
  EXPECT_TRUE(received(Channel::commands).empty()) << "it came out of contact";
  EXPECT_OK(router_->send(Channel::commands, ping));
}

TEST_F(PacketRouterTest, TheLinksRateIsKeptAndNearlyReached) {
  mission_.link_bytes_per_s = 125'000;
  const Bytes pdu = bare_pdu + Bytes(1000, 7);
  const double rate = double(sent_within(20 * ns_per_s, Channel::files, pdu)) / 20;
  EXPECT_LE(rate, 1.03 * mission_.link_bytes_per_s);
  EXPECT_GE(rate, 0.97 * mission_.link_bytes_per_s);
}

TEST_F(PacketRouterTest, TelemetryGoesWhileFilesHaveUsedUpTheRate) {
  mission_.link_bytes_per_s = 10'000;
  const Bytes pdu = bare_pdu + Bytes(1000, 7);
  while (router_->send(Channel::files, pdu).ok()) {
  }
  EXPECT_OK(router_->send(Channel::commands, ping));
  // Telemetry alone can take all of the rate, and no more.
  const std::size_t bytes = sent_within(10 * ns_per_s, Channel::commands, Bytes(100));
  EXPECT_LE(double(bytes), 1.1 * 10 * mission_.link_bytes_per_s);
  EXPECT_STATUS(router_->send(Channel::files, pdu), not_ready);
}

TEST_F(PacketRouterTest, ALinkWithoutRateCarriesNothing) {
  mission_.link_bytes_per_s = 0;
  EXPECT_STATUS(router_->send(Channel::commands, ping), not_ready);
  EXPECT_STATUS(router_->send(Channel::files, bare_pdu), not_ready);
}

TEST_F(PacketRouterTest, TelecommandsBeyondTheRateWait) {
  mission_.telecommands_per_s = 5;
  ground_sends(ping + ping + ping + ping + ping + ping + ping + ping);
  EXPECT_OK(router_->pump());
  EXPECT_EQ(received(Channel::commands).size(), 5U);
  clock_.sleep_until(ns_per_s / 5);
  EXPECT_EQ(received(Channel::commands).size(), 1U);
  clock_.sleep_until(10 * ns_per_s);
  EXPECT_EQ(received(Channel::commands).size(), 2U);
  EXPECT_EQ(router_->counts().dropped, 0U);
}

TEST_F(PacketRouterTest, AFloodIsBoundedCountedAndSurvived) {
  Bytes datagram;
  for (int i = 0; i < 300; ++i) datagram = datagram + ping;
  std::uint32_t sent = 0;
  for (int i = 0; i < 100; ++i) {
    ground_sends(datagram);
    sent += 300;
    EXPECT_OK(router_->pump());
  }
  const RouterCounts& counts = router_->counts();
  EXPECT_GT(counts.dropped, 0U);
  EXPECT_EQ(counts.received + counts.dropped, sent);
  ground_sends(wrapped_pdu);
  EXPECT_OK(router_->pump());
  EXPECT_EQ(received(Channel::files).size(), 1U) << "a flood of telecommands does not hinder files";
}

TEST_F(PacketRouterTest, PacketsOfEveryLengthPassWholeManyTimesAroundTheRing) {
  mission_.telecommands_per_s = 10000;
  for (std::size_t length = 1; length + 6 <= LoopbackDirection::packet_bytes; length += 7) {
    Bytes packet(6 + length, static_cast<std::uint8_t>(length));
    packet[0] = 0x18;
    packet[1] = 0xEF;
    packet[4] = static_cast<std::uint8_t>((length - 1) >> 8U);
    packet[5] = static_cast<std::uint8_t>(length - 1);
    ground_sends(packet);
    EXPECT_OK(router_->pump());
    ASSERT_EQ(received(Channel::commands), std::vector<Bytes>{packet}) << length;
    clock_.sleep_until(clock_.now() + ns_per_ms);
  }
}

TEST_F(PacketRouterTest, AFlightWithoutPacketLinkHasARouterThatDoesNothing) {
  PacketRouter router(nullptr, nullptr, clock_, mission_);
  EXPECT_FALSE(router.present());
  EXPECT_OK(router.pump());
  EXPECT_STATUS(router.send(Channel::commands, ping), not_ready);
  EXPECT_STATUS(router.send(Channel::files, bare_pdu), not_ready);
}

}  // namespace
}  // namespace ilp
