// The ground's end of packet links: takes telemetry, and receives files by CFDP.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/link/loopback/loopback_link.hpp"
#include "sim/ground/cfdp_receiver.hpp"

namespace ilp::faults {

class PacketGround {
 public:
  /// `clock` is not asked before the first packet goes.
  explicit PacketGround(Clock& clock) : clock_(clock), packets_(clock, {}), files_(clock, {}) {}

  [[nodiscard]] PacketLink& packets() { return packets_.board(); }
  [[nodiscard]] PacketLink& files() { return files_.board(); }

  /// Hears everything that has arrived. `keep` gets whole files.
  void listen(const sim::CfdpReceiver::Keep& keep) {
    if (!receiver_) {
      receiver_ = std::make_unique<sim::CfdpReceiver>(
          sim::CfdpReceiverSettings{},
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
  Clock& clock_;
  LoopbackLink packets_, files_;
  const sim::CfdpReceiver::Keep* keep_ = nullptr;
  std::unique_ptr<sim::CfdpReceiver> receiver_;
};

}  // namespace ilp::faults
