// Files from the board to the ground over links of every quality (docs/file-delivery.md).
#include <gtest/gtest.h>

#include <iostream>
#include <string>

#include "tests/support/delivery_rig.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::DeliveryRig;

constexpr int products = 200;

std::string name_of(int i) {
  return "product-" + std::to_string(100000 + i).substr(1) + "-image.jp2";
}

void offer_products(DeliveryRig& rig) {
  for (int i = 0; i < products; ++i) rig.offer(name_of(i), rig.noise(i == 7 ? 0 : 2000 + rig.random() % 40000));
}

std::uint64_t total_bytes(const DeliveryRig& rig) {
  std::uint64_t bytes = 0;
  for (const auto& [name, file] : rig.files) bytes += file.size();
  return bytes;
}

void expect_everything_on_ground(DeliveryRig& rig) {
  EXPECT_EQ(rig.on_ground.size(), rig.files.size());
  for (const auto& [name, file] : rig.files) EXPECT_TRUE(rig.on_ground[name] == file) << name;
  EXPECT_EQ(rig.confirmed.size(), rig.files.size());
  EXPECT_EQ(rig.transfers(), 0) << "kept after confirmation";
}

class LossyDelivery : public testing::TestWithParam<int> {};

TEST_P(LossyDelivery, TwoHundredProductsArriveIdenticalOverABadLinkWithOutagesAndRestarts) {
  LoopbackFaults faults;
  faults.seed = 11;
  faults.loss = GetParam() / 100.0;
  faults.duplication = 0.02;
  faults.reordering = 0.05;
  faults.delay_ns = 250 * ns_per_ms;
  faults.late_ns = 400 * ns_per_ms;
  faults.outage_period_ns = 25 * ns_per_s;
  faults.outage_length_ns = 6 * ns_per_s;
  DeliveryRig rig(faults);
  offer_products(rig);
  int board_restarts = 0;
  int ground_restarts = 0;
  int steps = 0;
  for (; !rig.done() && steps < 60000; ++steps) {
    rig.step();
    if (rig.random() % 150 == 0) {
      rig.reboot();
      ++board_restarts;
    }
    if (rig.random() % 250 == 0) {
      rig.restart_ground();
      ++ground_restarts;
    }
  }
  ASSERT_TRUE(rig.done()) << rig.sent.size() << " files never confirmed";
  expect_everything_on_ground(rig);
  EXPECT_GT(board_restarts, 0);
  EXPECT_GT(ground_restarts, 0);
  std::cout << "loss " << GetParam() << " %: " << total_bytes(rig) << " bytes in " << steps / 10.0 << " s of link, "
            << rig.link->lost() << " packets lost, " << board_restarts << " restarts on board, " << ground_restarts
            << " on the ground\n";
}
INSTANTIATE_TEST_SUITE_P(Losses, LossyDelivery, testing::Values(0, 5, 20));

TEST(FileDeliveryThroughput, TakesNineTenthsOfALinkOfOneMegabitASecond) {
  for (const TimeNs delay : {TimeNs{0}, 250 * ns_per_ms}) {
    LoopbackFaults faults{.delay_ns = delay};
    DeliveryRig rig(faults);
    offer_products(rig);
    const int steps = rig.run(4000);
    const double rate = static_cast<double>(total_bytes(rig)) / (steps * 0.1);
    expect_everything_on_ground(rig);
    EXPECT_EQ(rig.ground->counts().repeated_bytes, 0U);
    EXPECT_GE(rate, 0.9 * rig.mission.link_bytes_per_s) << delay;
    EXPECT_LE(rate, rig.mission.link_bytes_per_s) << delay;
    std::cout << "delay " << delay / ns_per_ms << " ms: " << 100 * rate / rig.mission.link_bytes_per_s
              << " % of 1 Mbit/s\n";
  }
}

TEST(FileDeliveryPasses, ContinueSegmentBySegmentFromPassToPass) {
  DeliveryRig rig;
  rig.mission.pass_period_s = 100;
  rig.mission.pass_length_s = 4;
  rig.offer("product-000001-image.jp2", rig.noise(1200000));
  const int steps = rig.run(4000);
  expect_everything_on_ground(rig);
  // 1.2 MB need 10 s of contact: three passes, with what is under way at their ends sent again.
  EXPECT_GT(steps, 2000);
  EXPECT_LT(steps, 2100);
  EXPECT_LT(rig.ground->counts().repeated_bytes, 30000U);
  EXPECT_FALSE(rig.saw(StatusCode::transfer_stalled)) << "timers ran out of contact";
}

}  // namespace
}  // namespace ilp
