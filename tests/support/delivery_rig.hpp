// Test rig for file delivery in virtual time: the onboard side that sends files, a ground station that receives them,
// and a link between them.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "fsw/base/crc.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/file_delivery.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/ground/cfdp/cfdp_receiver.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/loopback_link.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/executive/refusing_store.hpp"

namespace ilp::test {

using Bytes = std::vector<std::uint8_t>;

/// Acts as Downlink: hands files over, and counts a file as delivered only when the queue reports it.
class DeliveryRig {
 public:
  explicit DeliveryRig(const LoopbackFaults& faults = {}, std::uint32_t seed = 1)
      : link(std::make_unique<LoopbackLink>(clock, faults)), random(seed) {
    mission.link_bytes_per_s = 125000;
    reboot();
    restart_ground();
  }

  void offer(const std::string& name, Bytes file) {
    files[name] = file;
    to_send.push_back(name);
  }
  Bytes noise(std::size_t size) {
    Bytes bytes(size);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    return bytes;
  }

  /// Restarts the onboard side as after a power cut: only committed data remain.
  void reboot() {
    board = std::make_unique<Board>(*this);
    EXPECT_TRUE(board->delivery.restore().ok());
  }
  void restart_ground() {
    ground = std::make_unique<ground_cfdp::CfdpReceiver>(
        receiver, [this](const Bytes& pdu) { static_cast<void>(link->ground().send(pdu)); },
        [this](const std::string& name, const Bytes& file) {
          on_ground[name] = file;
          return ground_keeps;
        });
  }

  /// One minor frame.
  void step() {
    clock.sleep_until(clock.now() + 100 * ns_per_ms);
    hand_over();
    EXPECT_TRUE(board->router.pump().ok());
    const StepResult result = board->delivery.step();
    if (!result.status.ok()) events.push_back(result.status);
    receive();
    if (ground_listens) run_ground();
  }
  /// Steps until all files are confirmed, and returns the number of steps. The test fails if `most_steps` do not
  /// suffice.
  int run(int most_steps) {
    for (int i = 1; i <= most_steps; ++i) {
      step();
      if (done()) return i;
    }
    ADD_FAILURE() << "not done: " << to_send.size() << " to send, " << sent.size() << " not confirmed";
    return most_steps;
  }
  [[nodiscard]] bool done() const { return to_send.empty() && sent.empty(); }
  [[nodiscard]] double now_s() { return static_cast<double>(clock.now()) / static_cast<double>(ns_per_s); }
  [[nodiscard]] std::int64_t transfers() {
    std::int64_t count = -1;
    EXPECT_TRUE(store.count(record_info<TransferRecord>(), count).ok());
    return count;
  }
  [[nodiscard]] bool saw(StatusCode code) const {
    for (const Status& event : events) {
      if (event.is(code)) return true;
    }
    return false;
  }

  struct Board {
    explicit Board(DeliveryRig& rig)
        : router(nullptr, &rig.link->board(), rig.clock, rig.mission),
          queue(rig.store, rig.clock, rig.mission, step_memory<DeliveryQueue>(), &figures.backlog),
          delivery(rig.failing, router, rig.clock, rig.mission, figures, nullptr, rig.map) {}
    PacketRouter router;
    DeliveryFigures figures;
    DeliveryQueue queue;
    FileDelivery delivery;
  };

  VirtualClock clock;
  MissionParameters mission;
  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{48} << 20U);
  RamStore store{region};
  RefusingStore refusing{store};
  FailingStore failing{refusing};  ///< the store of FileDelivery
  MapFolder* map = nullptr;        ///< the map of FileDelivery from the next reboot() on
  std::unique_ptr<LoopbackLink> link;
  std::mt19937 random;
  std::unique_ptr<Board> board;
  ground_cfdp::CfdpReceiverSettings receiver;
  std::unique_ptr<ground_cfdp::CfdpReceiver> ground;
  bool ground_keeps = true;
  bool ground_listens = true;
  std::map<std::string, Bytes> files;      ///< files that were offered, by name
  std::map<std::string, Bytes> on_ground;  ///< files that the ground has kept; they survive its restarts
  std::deque<std::string> to_send;
  std::set<std::string> sent;       ///< files that were handed over and not confirmed
  std::set<std::string> confirmed;  ///< files that were confirmed, which Downlink would delete on board
  std::vector<Status> events;

 private:
  void hand_over() {
    while (!to_send.empty()) {
      const std::string name = to_send.front();
      const Bytes& file = files[name];
      Transaction transaction(store);
      ASSERT_TRUE(transaction.begin().ok());
      const Status begun = board->queue.begin_file(name.c_str());
      if (begun.is(StatusCode::transfer_queue_full)) return;
      ASSERT_TRUE(begun.ok()) << status_name(begun.code);
      ASSERT_TRUE(board->queue.write(file).ok());
      ASSERT_TRUE(board->queue.end_file().ok());
      ASSERT_TRUE(transaction.commit().ok());
      to_send.pop_front();
      sent.insert(name);
    }
  }
  void receive() {
    if (sent.empty()) return;
    Transaction transaction(store);
    ASSERT_TRUE(transaction.begin().ok());
    for (auto name = sent.begin(); name != sent.end();) {
      std::uint32_t bytes = 0;
      std::uint32_t crc = 0;
      const Status answer = board->queue.acknowledged(name->c_str(), bytes, crc);
      if (!answer.ok()) {
        ASSERT_TRUE(answer.is(StatusCode::not_ready)) << status_name(answer.code);
        ++name;
        continue;
      }
      EXPECT_TRUE(on_ground.count(*name) == 1 && on_ground[*name] == files[*name]) << *name << " deleted too early";
      EXPECT_EQ(bytes, files[*name].size());
      EXPECT_EQ(crc, crc32(files[*name]));
      EXPECT_TRUE(confirmed.insert(*name).second) << *name << " confirmed twice";
      name = sent.erase(name);
    }
    ASSERT_TRUE(transaction.commit().ok());
  }
  void run_ground() {
    Bytes buffer(8192);
    std::size_t bytes = 0;
    while (link->ground().receive(buffer, bytes).ok()) ground->receive(std::span(buffer).first(bytes), now_s());
    ground->tick(now_s());
  }
};

}  // namespace ilp::test
