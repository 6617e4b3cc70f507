// The ground of a recorded flight: an operator who sends telecommands at set times, and both ends of files.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/packets/authentication.hpp"
#include "fsw/packets/link_settings.hpp"
#include "fsw/packets/pus.hpp"
#include "sim/ground/cfdp/cfdp_receiver.hpp"
#include "sim/ground/cfdp/cfdp_sender.hpp"
#include "tests/support/loopback_link.hpp"

namespace ilp::test {

inline constexpr std::uint16_t station_spi = 7;
inline constexpr std::array<std::uint8_t, 32> station_key = {1, 2, 3};

class GroundStation {
 public:
  using Bytes = std::vector<std::uint8_t>;

  GroundStation(Clock& clock, const MissionParameters& mission)
      : clock_(clock), mission_(mission), packets_(clock, {}), files_(clock, {}) {}

  [[nodiscard]] PacketLink& packets() { return packets_.board(); }
  [[nodiscard]] PacketLink& files() { return files_.board(); }
  /// Every telecommand has been sent, and the file has arrived.
  [[nodiscard]] bool done() const {
    return next_ == script_.size() && sender_.transfer(file_).state == ground_cfdp::CfdpSender::State::retained;
  }

  /// After every minor frame.
  void listen() {
    const TimeNs now = clock_.now();
    const double now_s = 1e-9 * static_cast<double>(now);
    if (file_ == 0) file_ = sender_.put("slow.ini", text("[executive]\nscrub_period_s = 1000\n"), now_s);
    for (; next_ < script_.size() && script_[next_].at <= now; ++next_) {
      const Line& line = script_[next_];
      const bool schedules = line.service == 11 && line.subtype == 4;
      static_cast<void>(
          packets_.ground().send(packet(line.service, line.subtype, schedules ? scheduled_ping() : line.data)));
    }
    Bytes buffer(LoopbackDirection::packet_bytes);
    std::size_t bytes = 0;
    while (packets_.ground().receive(buffer, bytes).ok()) continue;
    while (files_.ground().receive(buffer, bytes).ok()) {
      receiver_.receive(std::span(buffer).first(bytes), now_s);
      sender_.receive(std::span(buffer).first(bytes), now_s);
    }
    receiver_.tick(now_s);
    sender_.tick(now_s);
  }

 private:
  struct Line {
    TimeNs at;
    std::uint8_t service, subtype;
    Bytes data;
  };

  static Bytes text(const std::string& content) { return {content.begin(), content.end()}; }
  static Bytes function(const char* name, const Bytes& arguments = {}) {
    Bytes data(8, 0);
    std::memcpy(data.data(), name, std::strlen(name));
    data.insert(data.end(), arguments.begin(), arguments.end());
    return data;
  }
  Bytes plain(std::uint8_t service, std::uint8_t subtype, const Bytes& data = {}) {
    Telecommand telecommand;
    telecommand.primary.apid = static_cast<std::uint16_t>(mission_.apid);
    telecommand.primary.sequence_count = count_++;
    telecommand.ack_flags = 0x0F;
    telecommand.service = service;
    telecommand.subtype = subtype;
    telecommand.source = 1;
    telecommand.data = data;
    Bytes octets(13 + data.size());
    std::size_t bytes = 0;
    EXPECT_TRUE(encode_telecommand(telecommand, octets, bytes).ok());
    return octets;
  }
  Bytes packet(std::uint8_t service, std::uint8_t subtype, const Bytes& data = {}) {
    const Bytes octets = plain(service, subtype, data);
    if (mission_.authentication == Authentication::none) return octets;
    Bytes sealed(octets.size() + 64);
    std::size_t bytes = 0;
    EXPECT_TRUE(seal(octets, station_spi, ++sealed_, station_key, sealed, bytes).ok());
    sealed.resize(bytes);
    return sealed;
  }
  Bytes scheduled_ping() {
    Bytes data = {0, 1};
    const LinkSettings settings(mission_);
    std::array<std::uint8_t, 16> octets{};
    ByteWriter time(octets);
    EXPECT_TRUE(encode_time(settings.tailoring.time, settings.time.utc(clock_.now() + 2 * ns_per_s), time).ok());
    data.insert(data.end(), octets.begin(), octets.begin() + static_cast<std::ptrdiff_t>(time.size()));
    const Bytes ping = plain(17, 1);
    data.insert(data.end(), ping.begin(), ping.end());
    return data;
  }

  static constexpr std::uint8_t sid_storage = 5;
  /// Every kind of effect: a report, a periodic report, a record that another stage obeys, a schedule, a rejection, a
  /// kind of event that is not reported any more, and a file that takes effect. Without data [11,4] schedules a ping.
  const std::vector<Line> script_ = {
      {700 * ns_per_ms, 17, 1, {}},
      {1300 * ns_per_ms, 3, 5, {0, 1, sid_storage}},
      {2300 * ns_per_ms, 8, 1, function("CAPTURE", {9})},
      {3300 * ns_per_ms, 11, 4, {}},
      {3700 * ns_per_ms, 11, 1, {}},
      {4300 * ns_per_ms, 8, 1, function("NOSUCH")},
      {7300 * ns_per_ms, 8, 1, function("STRIPEND")},
      {8300 * ns_per_ms, 5, 6, {0, 1, 0, 1}},
      {9300 * ns_per_ms, 8, 1, function("REFINE", {0, 0, 0, 1})},
      {12300 * ns_per_ms, 8, 1, function("ACTIVATE", {0, 0, 0, 1})},
  };

  Clock& clock_;
  const MissionParameters& mission_;
  LoopbackLink packets_, files_;
  ground_cfdp::CfdpReceiver receiver_{{},
                                      [this](const Bytes& pdu) { static_cast<void>(files_.ground().send(pdu)); },
                                      [](const std::string&, const Bytes&) { return true; }};
  ground_cfdp::CfdpSender sender_{{}, [this](const Bytes& pdu) { static_cast<void>(files_.ground().send(pdu)); }};
  std::uint64_t file_ = 0;
  std::size_t next_ = 0;
  std::uint16_t count_ = 0;
  std::uint32_t sealed_ = 0;
};

}  // namespace ilp::test
