// A ground that sends files up to FileDelivery.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "sim/ground/cfdp/cfdp_sender.hpp"
#include "tests/support/delivery_rig.hpp"

namespace ilp::test {

class UplinkTest : public testing::Test {
 protected:
  UplinkTest() { rig.ground_listens = false; }

  void step() {
    rig.step();
    Bytes buffer(8192);
    std::size_t bytes = 0;
    while (rig.link->ground().receive(buffer, bytes).ok()) {
      sender.receive(std::span<const std::uint8_t>(buffer).first(bytes), rig.now_s());
    }
    sender.tick(rig.now_s());
  }
  ground_cfdp::CfdpSender::Transfer put(const std::string& name, const Bytes& file, int most_steps = 3000) {
    const std::uint64_t sequence = sender.put(name, file, rig.now_s());
    for (int i = 0; i < most_steps && sender.transfer(sequence).state == ground_cfdp::CfdpSender::State::going; ++i)
      step();
    return sender.transfer(sequence);
  }
  UplinkRecord newest() {
    UplinkRecord record;
    EXPECT_TRUE(last(rig.store, record).ok());
    return record;
  }
  Status activate(std::int64_t id, MissionParameters& mission) {
    Transaction transaction(rig.store);
    EXPECT_TRUE(transaction.begin().ok());
    const Status status = activate_uplink(rig.store, id, rig.clock.now(), mission);
    if (status.ok()) {
      EXPECT_TRUE(transaction.commit().ok());
    }
    return status;
  }

  DeliveryRig rig;
  ground_cfdp::CfdpSender sender{{}, [this](const Bytes& pdu) { static_cast<void>(rig.link->ground().send(pdu)); }};
};

}  // namespace ilp::test
