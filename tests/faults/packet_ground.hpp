// The ground's end of packet links: takes telemetry, and receives files by CFDP.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/packets/pus.hpp"
#include "sim/ground/cfdp/cfdp_receiver.hpp"
#include "tests/support/loopback_link.hpp"

namespace ilp::faults {

class PacketGround {
 public:
  /// `clock` is not asked before the first packet goes.
  explicit PacketGround(Clock& clock) : clock_(clock), packets_(clock, {}), files_(clock, {}) {}

  [[nodiscard]] PacketLink& packets() { return packets_.board(); }
  [[nodiscard]] PacketLink& files() { return files_.board(); }

  /// Hears everything that has arrived. `keep` gets whole files. The first time it pings, as an operator does who sees
  /// the flight start: an accepted telecommand confirms its parameters.
  void listen(const ground_cfdp::CfdpReceiver::Keep& keep) {
    if (!receiver_) ping();
    if (!receiver_) {
      receiver_ = std::make_unique<ground_cfdp::CfdpReceiver>(
          ground_cfdp::CfdpReceiverSettings{},
          [this](const std::vector<std::uint8_t>& pdu) { static_cast<void>(files_.ground().send(pdu)); },
          [this](const std::string& name, const std::vector<std::uint8_t>& file) { return (*keep_)(name, file); });
    }
    keep_ = &keep;
    const double now_s = 1e-9 * static_cast<double>(clock_.now());
    std::vector<std::uint8_t> buffer(LoopbackDirection::packet_bytes);
    std::size_t bytes = 0;
    while (packets_.ground().receive(buffer, bytes).ok()) {
    }
    while (files_.ground().receive(buffer, bytes).ok()) {
      receiver_->receive(std::span(buffer).first(bytes), now_s);
    }
    receiver_->tick(now_s);
    keep_ = nullptr;
  }

 private:
  void ping() {
    Telecommand telecommand;
    telecommand.primary.apid = static_cast<std::uint16_t>(MissionParameters{}.apid);
    telecommand.service = 17;
    telecommand.subtype = 1;
    telecommand.source = 1;
    std::array<std::uint8_t, 64> octets{};
    std::size_t bytes = 0;
    if (!encode_telecommand(telecommand, octets, bytes).ok()) throw std::runtime_error("no telecommand");
    static_cast<void>(packets_.ground().send(std::span(octets).first(bytes)));
  }

  Clock& clock_;
  LoopbackLink packets_, files_;
  const ground_cfdp::CfdpReceiver::Keep* keep_ = nullptr;
  std::unique_ptr<ground_cfdp::CfdpReceiver> receiver_;
};

}  // namespace ilp::faults
