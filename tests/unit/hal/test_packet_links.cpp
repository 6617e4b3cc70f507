// Packet links over real sockets: whole packets or none, hostile peers, peers that vanish; and the loopback's faults.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "hal/clock/virtual_clock.hpp"
#include "hal/link/joined_link.hpp"
#include "hal/link/tcp/tcp_link.hpp"
#include "hal/link/udp/udp_link.hpp"
#include "tests/support/loopback_link.hpp"
#include "tests/support/socket_client.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::TcpClient;
using test::UdpClient;

Bytes packet_of(std::size_t data_bytes, std::uint8_t fill = 0x55) {
  Bytes packet(6 + data_bytes, fill);
  packet[0] = 0x18;
  packet[1] = 0xEF;
  packet[2] = 0xC0;
  packet[4] = static_cast<std::uint8_t>((data_bytes - 1) >> 8U);
  packet[5] = static_cast<std::uint8_t>(data_bytes - 1);
  return packet;
}
Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// What comes within a bounded number of looks.
Bytes next(PacketLink& link, Status* status = nullptr) {
  Bytes buffer(limits::max_packet_bytes);
  std::size_t size = 0;
  Status last;
  for (int i = 0; i < 20'000; ++i) {
    last = link.receive(buffer, size);
    if (!last.is(StatusCode::not_ready)) break;
    ::usleep(500);
  }
  if (status != nullptr) *status = last;
  buffer.resize(last.ok() ? size : 0);
  return buffer;
}
/// Lets a link work without anything to be expected.
void turn(PacketLink& link, int times = 20) {
  Bytes buffer(limits::max_packet_bytes);
  std::size_t size = 0;
  for (int i = 0; i < times; ++i) {
    static_cast<void>(link.receive(buffer, size));
    ::usleep(500);
  }
}

TEST(SocketAddressTest, OnlyFourNumbersAndAPortAreAnAddress) {
  SocketAddress address;
  EXPECT_OK(parse_address("127.0.0.1:10025", address));
  EXPECT_EQ(address, (SocketAddress{0x7F000001, 10025}));
  for (const char* wrong :
       {"", ":", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:1x", "localhost:1", "1.2.3:4",
        "256.0.0.1:1", "127.0.0.1:000001", "127.0.0.1 :1", "1111111111111111111111111111.0.0.1:1"}) {
    EXPECT_STATUS(parse_address(wrong, address), parse_error) << wrong;
  }
  EXPECT_EQ(address.port, 10025) << "unchanged by what is wrong";
}

class UdpLinkTest : public testing::Test {
 protected:
  UdpLinkTest() {
    EXPECT_OK(link_.open(test::any_port, nullptr));
    EXPECT_OK(link_.address(board_));
  }
  void receive_from(UdpClient& station) {
    station.send(packet_of(7));
    EXPECT_EQ(next(link_), packet_of(7));
    link_.accept_sender();
  }
  VirtualClock clock_;
  UdpLink link_{clock_};
  SocketAddress board_;
};

TEST_F(UdpLinkTest, NobodyHearsBeforeAStationWasAccepted) {
  UdpClient station(board_);
  EXPECT_STATUS(link_.send(packet_of(9)), not_ready);
  station.send(packet_of(7));
  EXPECT_EQ(next(link_), packet_of(7));
  EXPECT_STATUS(link_.send(packet_of(9)), not_ready) << "what it sent made no sense";
  link_.accept_sender();
  EXPECT_OK(link_.send(packet_of(9)));
  EXPECT_EQ(station.receive(), packet_of(9));
}

TEST_F(UdpLinkTest, TwoStationsHearTheSameTelemetryUntilTheyHaveBeenSilentForLong) {
  UdpClient one(board_), two(board_);
  receive_from(one);
  clock_.sleep_until(UdpLink::station_lifetime_ns);
  receive_from(two);
  EXPECT_OK(link_.send(packet_of(9)));
  EXPECT_EQ(one.receive(), packet_of(9));
  EXPECT_EQ(two.receive(), packet_of(9));
  clock_.sleep_until(clock_.now() + 1);
  EXPECT_OK(link_.send(packet_of(10)));
  EXPECT_EQ(two.receive(), packet_of(10));
  EXPECT_FALSE(one.receive(50).has_value());
}

TEST_F(UdpLinkTest, StationsAreBoundedTheLongestSilentGivesItsPlace) {
  std::vector<std::unique_ptr<UdpClient>> stations;
  for (std::size_t i = 0; i <= limits::max_stations; ++i) {
    stations.push_back(std::make_unique<UdpClient>(board_));
    receive_from(*stations.back());
    clock_.sleep_until(clock_.now() + ns_per_s);
  }
  EXPECT_OK(link_.send(packet_of(9)));
  for (std::size_t i = 1; i < stations.size(); ++i) EXPECT_EQ(stations[i]->receive(), packet_of(9)) << i;
  EXPECT_FALSE(stations[0]->receive(50).has_value());
}

TEST_F(UdpLinkTest, AFixedPeerAloneIsSentTo) {
  UdpClient peer(board_), stranger(board_);
  const SocketAddress to = peer.address();
  UdpLink link(clock_);
  EXPECT_OK(link.open(test::any_port, &to));
  SocketAddress board;
  EXPECT_OK(link.address(board));
  EXPECT_OK(link.send(packet_of(9)));
  EXPECT_EQ(peer.receive(), packet_of(9));
  UdpClient other(board);
  other.send(packet_of(7));
  EXPECT_EQ(next(link), packet_of(7));
  link.accept_sender();
  EXPECT_OK(link.send(packet_of(9)));
  EXPECT_FALSE(other.receive(50).has_value());
}

TEST_F(UdpLinkTest, AStationThatVanishesDoesNoHarm) {
  UdpClient stays(board_);
  {
    UdpClient goes(board_);
    receive_from(goes);
  }
  receive_from(stays);
  for (int i = 0; i < 20; ++i) {
    EXPECT_OK(link_.send(packet_of(9)));
    EXPECT_EQ(stays.receive(), packet_of(9));
  }
  receive_from(stays);
}

TEST_F(UdpLinkTest, DatagramsOfEveryLengthComeWholeOrAreRefused) {
  UdpClient station(board_);
  for (const std::size_t size : {0U, 1U, 5U, 6U, 1472U, 1473U, 9000U, 65507U}) {
    station.send(Bytes(size, 1));
    Status status;
    EXPECT_EQ(next(link_, &status).size(), size);
    EXPECT_OK(status);
  }
  station.send(Bytes(101, 1));
  Bytes small(100);
  std::size_t size = 0;
  Status status = StatusCode::not_ready;
  for (int i = 0; i < 2000 && status.is(StatusCode::not_ready); ++i) status = link_.receive(small, size);
  EXPECT_STATUS(status, capacity_exceeded);
  receive_from(station);
  EXPECT_STATUS(link_.send(Bytes(65508)), capacity_exceeded);
}

TEST_F(UdpLinkTest, AFloodLeavesALinkThatWorks) {
  UdpClient station(board_);
  for (int i = 0; i < 20000; ++i) station.send(Bytes(static_cast<std::size_t>(i % 1400), 7));
  Bytes buffer(limits::max_packet_bytes);
  std::size_t size = 0;
  while (link_.receive(buffer, size).ok()) {
  }
  receive_from(station);
}

TEST_F(UdpLinkTest, AnAddressThatIsTakenOrNotOursIsAnError) {
  UdpLink second(clock_);
  EXPECT_STATUS(second.open(board_, nullptr), io_error);
  EXPECT_STATUS(second.open({0xC0000201, 0}, nullptr), io_error);
}

class TcpLinkTest : public testing::Test {
 protected:
  TcpLinkTest() {
    EXPECT_OK(link_->open(test::any_port));
    EXPECT_OK(link_->address(board_));
  }
  VirtualClock clock_;
  std::unique_ptr<TcpLink> link_ = std::make_unique<TcpLink>(clock_);
  SocketAddress board_;
};

TEST_F(TcpLinkTest, PacketsBackToBackAreCutByTheirLength) {
  TcpClient client(board_);
  EXPECT_TRUE(client.send(packet_of(7) + packet_of(1) + packet_of(300)));
  EXPECT_EQ(next(*link_), packet_of(7));
  EXPECT_EQ(next(*link_), packet_of(1));
  EXPECT_EQ(next(*link_), packet_of(300));
}

TEST_F(TcpLinkTest, APacketMayComeOctetByOctet) {
  TcpClient client(board_);
  const Bytes packet = packet_of(20);
  for (const std::uint8_t& byte : packet) {
    EXPECT_TRUE(client.send({byte}));
    if (&byte != &packet.back()) turn(*link_, 1);
  }
  EXPECT_EQ(next(*link_), packet);
}

TEST_F(TcpLinkTest, TheLargestPacketsPassBothWays) {
  TcpClient client(board_);
  const Bytes largest = packet_of(65536);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(client.send(packet_of(1000) + largest));
    EXPECT_EQ(next(*link_), packet_of(1000));
    EXPECT_EQ(next(*link_), largest);
    EXPECT_OK(link_->send(largest));
    EXPECT_EQ(client.receive(largest.size()), largest);
  }
}

TEST_F(TcpLinkTest, EveryClientHearsTelemetryWithoutHavingSaidAnything) {
  EXPECT_STATUS(link_->send(packet_of(9)), not_ready);
  TcpClient one(board_), two(board_);
  turn(*link_);
  EXPECT_OK(link_->send(packet_of(9)));
  EXPECT_EQ(one.receive(15), packet_of(9));
  EXPECT_EQ(two.receive(15), packet_of(9));
}

TEST_F(TcpLinkTest, AClientThatEndsSendingStillListens) {
  TcpClient client(board_);
  EXPECT_TRUE(client.send(packet_of(7)));
  client.end_sending();
  EXPECT_EQ(next(*link_), packet_of(7));
  turn(*link_);
  EXPECT_OK(link_->send(packet_of(9)));
  EXPECT_EQ(client.receive(15), packet_of(9));
}

TEST_F(TcpLinkTest, ANewClientIsAlwaysHeardTheOneThatWasSilentForLongestGivesWay) {
  std::vector<std::unique_ptr<TcpClient>> idle;
  for (std::size_t i = 0; i < limits::max_tcp_clients; ++i) {
    idle.push_back(std::make_unique<TcpClient>(board_));
    turn(*link_);
  }
  EXPECT_EQ(link_->clients(), limits::max_tcp_clients);
  TcpClient station(board_);
  EXPECT_TRUE(station.send(packet_of(7)));
  EXPECT_EQ(next(*link_), packet_of(7));
  EXPECT_TRUE(idle[0]->closed());
  EXPECT_FALSE(idle[1]->closed(50));
  EXPECT_EQ(link_->counts().gave_way, 1U);
  EXPECT_EQ(link_->clients(), limits::max_tcp_clients);
}

TEST_F(TcpLinkTest, WhoHasSentAnAcceptedTelecommandKeepsItsPlaceBeforeThoseThatOnlyCame) {
  TcpClient station(board_);
  EXPECT_TRUE(station.send(packet_of(7)));
  EXPECT_EQ(next(*link_), packet_of(7));
  link_->accept_sender();
  std::vector<std::unique_ptr<TcpClient>> idle;
  for (std::size_t i = 0; i < 50; ++i) {
    idle.push_back(std::make_unique<TcpClient>(board_));
    // What is no telecommand of ours, or not authentic, is no reason to stay.
    EXPECT_TRUE(idle.back()->send(packet_of(9)));
    EXPECT_EQ(next(*link_), packet_of(9));
  }
  EXPECT_TRUE(station.send(packet_of(8)));
  EXPECT_EQ(next(*link_), packet_of(8));
  EXPECT_FALSE(station.closed(50));
}

TEST_F(TcpLinkTest, OfStationsTheOneThatCommandedLastStays) {
  std::vector<std::unique_ptr<TcpClient>> stations;
  for (std::size_t i = 0; i < limits::max_tcp_clients; ++i) stations.push_back(std::make_unique<TcpClient>(board_));
  // The first that came was the last to command.
  for (std::size_t i = stations.size(); i-- > 0;) {
    EXPECT_TRUE(stations[i]->send(packet_of(7)));
    EXPECT_EQ(next(*link_), packet_of(7));
    link_->accept_sender();
  }
  TcpClient one(board_), two(board_);
  EXPECT_TRUE(one.send(packet_of(8)));
  EXPECT_EQ(next(*link_), packet_of(8));
  EXPECT_TRUE(stations.back()->closed());
  EXPECT_TRUE(two.send(packet_of(9)));
  EXPECT_EQ(next(*link_), packet_of(9));
  EXPECT_TRUE(one.closed()) << "it has sent nothing that was accepted";
  for (std::size_t i = 0; i + 1 < stations.size(); ++i) EXPECT_FALSE(stations[i]->closed(50)) << i;
}

TEST_F(TcpLinkTest, AFloodOfConnectionsLeavesEachTheTimeToSayWhatItCameFor) {
  std::vector<std::unique_ptr<TcpClient>> flood;
  for (int i = 0; i < 10; ++i) {
    flood.push_back(std::make_unique<TcpClient>(board_));
    EXPECT_TRUE(flood.back()->send(packet_of(20, static_cast<std::uint8_t>(i))));
  }
  for (int i = 0; i < 10; ++i) EXPECT_EQ(next(*link_), packet_of(20, static_cast<std::uint8_t>(i)));
}

TEST_F(TcpLinkTest, TelemetryIsSentWhenAStationTookItNotWhenAnybodyDid) {
  TcpClient station(board_, 4096), listener(board_);
  EXPECT_TRUE(station.send(packet_of(7)));
  EXPECT_EQ(next(*link_), packet_of(7));
  link_->accept_sender();
  turn(*link_);
  const Bytes packet = packet_of(1000);
  // The listener takes everything, the station nothing: what the station misses counts as not sent, and no client gets
  // it twice.
  std::size_t sent = 0;
  while (sent < 5000 && link_->send(packet).ok()) {
    ++sent;
    ASSERT_EQ(listener.receive(packet.size()), packet);
  }
  EXPECT_LT(sent, 5000U);
  EXPECT_EQ(listener.receive(1, 50), Bytes());
  // A station that never reads is closed: then the listener is who telemetry is for.
  // (The system's own queues may take a little more of it on the way.)
  for (int i = 0; i < 20 && link_->counts().unread == 0; ++i) {
    clock_.sleep_until(clock_.now() + TcpLink::patience_ns + 1);
    turn(*link_);
  }
  EXPECT_EQ(link_->counts().unread, 1U);
  EXPECT_OK(link_->send(packet));
  EXPECT_EQ(listener.receive(packet.size()), packet);
}

TEST_F(TcpLinkTest, AClientThatVanishesMakesRoom) {
  for (int i = 0; i < 20; ++i) {
    TcpClient client(board_);
    EXPECT_TRUE(client.send(packet_of(7) + Bytes(3, 0x18)));
    EXPECT_EQ(next(*link_), packet_of(7));
    client.vanish();
    turn(*link_, 4);
  }
  EXPECT_EQ(link_->clients(), 0U);
  EXPECT_STATUS(link_->send(packet_of(9)), not_ready);
}

TEST_F(TcpLinkTest, AClientThatDoesNotReadNeverHoldsHalfAPacketAndIsClosed) {
  TcpClient sleeper(board_, 4096);
  turn(*link_);
  const Bytes packet = packet_of(1000);
  std::size_t taken = 0;
  while (link_->send(packet).ok()) ++taken;
  EXPECT_GT(taken, 20U);
  // It wakes up in time: everything that was taken is there, whole.
  clock_.sleep_until(clock_.now() + TcpLink::patience_ns);
  Bytes stream;
  for (int i = 0; i < 1000 && stream.size() < taken * packet.size(); ++i) {
    turn(*link_, 1);
    stream = stream + sleeper.receive(std::min<std::size_t>(10000, taken * packet.size() - stream.size()), 5);
  }
  ASSERT_EQ(stream.size(), taken * packet.size());
  for (std::size_t i = 0; i < taken; ++i) {
    ASSERT_EQ(Bytes(stream.begin() + long(i * packet.size()), stream.begin() + long((i + 1) * packet.size())), packet);
  }
  // It sleeps for good.
  while (link_->send(packet).ok()) {
  }
  EXPECT_EQ(link_->counts().unread, 0U);
  clock_.sleep_until(clock_.now() + TcpLink::patience_ns + 1);
  turn(*link_, 1);
  EXPECT_EQ(link_->counts().unread, 1U);
  EXPECT_EQ(link_->clients(), 0U);
}

TEST_F(TcpLinkTest, AClientThatDoesNotReadDoesNotStopTheOthers) {
  TcpClient sleeper(board_, 4096), reader(board_);
  turn(*link_);
  const Bytes packet = packet_of(1000);
  for (int i = 0; i < 3000; ++i) {
    ASSERT_OK(link_->send(packet));
    ASSERT_EQ(reader.receive(packet.size()), packet);
  }
  EXPECT_GT(link_->counts().skipped, 0U);
}

TEST_F(TcpLinkTest, GarbageEndsTheConnectionAndIsCounted) {
  TcpClient client(board_);
  EXPECT_TRUE(client.send(Bytes(100000, 0xFF)));
  turn(*link_);
  EXPECT_TRUE(client.closed());
  EXPECT_EQ(link_->counts().garbage, 1U);
}

TEST_F(TcpLinkTest, APacketOfAnotherVersionIsPassedOnToBeCountedWhenTheNextOneFollows) {
  TcpClient client(board_);
  Bytes odd = packet_of(7);
  odd[0] = 0x38;
  EXPECT_TRUE(client.send(odd + packet_of(9)));
  EXPECT_EQ(next(*link_), odd);
  EXPECT_EQ(next(*link_), packet_of(9));
  for (int i = 0; i < 16; ++i) {
    EXPECT_TRUE(client.send(odd));
    EXPECT_EQ(next(*link_), odd);
  }
  EXPECT_TRUE(client.send(odd));
  turn(*link_);
  EXPECT_TRUE(client.closed());
}

TEST_F(TcpLinkTest, APacketThatDoesNotEndIsNotWaitedForForEver) {
  TcpClient client(board_);
  const Bytes packet = packet_of(60000);
  EXPECT_TRUE(client.send(Bytes(packet.begin(), packet.begin() + 1000)));
  turn(*link_);
  clock_.sleep_until(clock_.now() + TcpLink::patience_ns);
  turn(*link_);
  EXPECT_EQ(link_->clients(), 1U);
  clock_.sleep_until(clock_.now() + 1);
  turn(*link_);
  EXPECT_EQ(link_->clients(), 0U);
  EXPECT_EQ(link_->counts().garbage, 1U);
}

TEST_F(TcpLinkTest, OneClientThatFloodsDoesNotSilenceAnother) {
  TcpClient flood(board_), other(board_);
  Bytes many;
  for (int i = 0; i < 2000; ++i) many = many + packet_of(20, 1);
  EXPECT_TRUE(flood.send(many));
  turn(*link_, 3);
  EXPECT_TRUE(other.send(packet_of(30, 2)));
  bool received = false;
  for (int i = 0; i < 200 && !received; ++i) received = next(*link_) == packet_of(30, 2);
  EXPECT_TRUE(received);
}

TEST_F(TcpLinkTest, TwoLinksAreOne) {
  UdpLink udp(clock_);
  EXPECT_OK(udp.open(test::any_port, nullptr));
  SocketAddress address;
  EXPECT_OK(udp.address(address));
  JoinedLink joined(udp, *link_);
  UdpClient station(address);
  TcpClient client(board_);
  station.send(packet_of(7));
  EXPECT_EQ(next(joined), packet_of(7));
  joined.accept_sender();
  EXPECT_TRUE(client.send(packet_of(8)));
  EXPECT_EQ(next(joined), packet_of(8));
  joined.accept_sender();
  EXPECT_OK(joined.send(packet_of(9)));
  EXPECT_EQ(station.receive(), packet_of(9));
  EXPECT_EQ(client.receive(15), packet_of(9));
}

class LoopbackTest : public testing::Test {
 protected:
  std::vector<int> fly(const LoopbackFaults& faults, int packets) {
    auto link = std::make_unique<LoopbackLink>(clock_, faults);
    std::vector<int> received;
    std::array<std::uint8_t, 16> buffer{};
    std::size_t size = 0;
    for (int i = 0; i < packets + 200; ++i) {
      const std::array<std::uint8_t, 2> packet{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i)};
      if (i < packets) {
        EXPECT_OK(link->board().send(packet));
      }
      while (link->ground().receive(buffer, size).ok()) received.push_back(buffer[0] << 8 | buffer[1]);
      clock_.sleep_until(clock_.now() + ns_per_ms);
    }
    return received;
  }
  VirtualClock clock_;
};

TEST_F(LoopbackTest, WithoutFaultsEverythingComesInOrder) {
  const std::vector<int> received = fly({}, 1000);
  ASSERT_EQ(received.size(), 1000U);
  EXPECT_TRUE(std::is_sorted(received.begin(), received.end()));
}

TEST_F(LoopbackTest, FaultsComeAsOftenAsAskedAndTheSameEveryTime) {
  const LoopbackFaults faults{.seed = 7, .loss = 0.2, .duplication = 0.1, .reordering = 0.1};
  const std::vector<int> received = fly(faults, 10000);
  const std::set<int> different(received.begin(), received.end());
  EXPECT_NEAR(double(different.size()), 8000, 4 * 40);  // binomial: sigma 40
  EXPECT_NEAR(double(received.size() - different.size()), 800, 4 * 27);
  EXPECT_FALSE(std::is_sorted(received.begin(), received.end()));
  clock_.sleep_until(1000 * ns_per_s);
  EXPECT_EQ(fly(faults, 10000), received);
  EXPECT_NE(fly({.seed = 8, .loss = 0.2, .duplication = 0.1, .reordering = 0.1}, 10000), received);
}

TEST_F(LoopbackTest, DelayAndOutages) {
  auto link = std::make_unique<LoopbackLink>(
      clock_, LoopbackFaults{.delay_ns = 5, .outage_period_ns = 1000, .outage_length_ns = 100});
  const std::array<std::uint8_t, 1> packet{1};
  std::array<std::uint8_t, 1> buffer{};
  std::size_t size = 0;
  EXPECT_OK(link->ground().send(packet));
  clock_.sleep_until(4);
  EXPECT_STATUS(link->board().receive(buffer, size), not_ready);
  clock_.sleep_until(5);
  EXPECT_OK(link->board().receive(buffer, size));
  clock_.sleep_until(900);
  EXPECT_OK(link->ground().send(packet));
  clock_.sleep_until(999);
  EXPECT_OK(link->ground().send(packet));
  EXPECT_EQ(link->lost(), 2U);
  clock_.sleep_until(1000);
  EXPECT_OK(link->ground().send(packet));
  EXPECT_EQ(link->lost(), 2U);
}

}  // namespace
}  // namespace ilp
