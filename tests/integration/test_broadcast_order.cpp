// The order of products on the packet link: what is worth most begins first (docs/links.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "bsp/flight/flight_software.hpp"
#include "fsw/downlink/downlink.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "fsw/shared/product_layers.hpp"
#include "tests/faults/packet_ground.hpp"
#include "tests/stages/recorded_flight.hpp"
#include "tests/support/delivery_rig.hpp"
#include "tests/support/flight_kit.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/store_records.hpp"

namespace ilp::test {
namespace {

/// The names of products in the order in which their transactions begin. Transaction numbers grow, and a record is seen
/// in the minor frame in which its transaction begins.
class Beginnings {
 public:
  /// The names that are new since the last call.
  std::vector<std::string> look(Store& store) {
    std::map<std::int64_t, std::string> fresh;
    for (const TransferRecord& record : records_of<TransferRecord>(store)) {
      const std::string name = record.name;
      if (record.sequence > newest_ && name.starts_with("product-")) fresh[record.sequence] = name;
    }
    std::vector<std::string> names;
    for (const auto& [sequence, name] : fresh) {
      newest_ = sequence;
      names.push_back(name);
      all.push_back(name);
    }
    return names;
  }

  std::vector<std::string> all;

 private:
  std::int64_t newest_ = 0;
};

class BroadcastOrder : public testing::TestWithParam<double> {
 protected:
  BroadcastOrder() : rig(faults()) {
    rig.mission.link_bytes_per_s = 4000;  // 2 % of an image of 640 x 480 px every 1.5 s
    rig.mission.pass_period_s = 120;
    rig.mission.pass_length_s = 40;
    rig.mission.cfdp_timer_s = 2;
    rig.ground = std::make_unique<ground_cfdp::CfdpReceiver>(
        rig.receiver, [this](const Bytes& pdu) { static_cast<void>(rig.link->ground().send(pdu)); },
        [this](const std::string& name, const Bytes&) {
          if (name.starts_with("product-")) arrived.push_back(name);
          return true;
        });
    EXPECT_TRUE(downlink->restore().ok());
  }
  static LoopbackFaults faults() {
    LoopbackFaults faults{.loss = GetParam()};
    return faults;
  }
  static std::string name_of(std::int64_t keyframe) {
    return "product-" + std::to_string(1000000 + keyframe).substr(1) + "-image.jp2";
  }
  void add(std::int64_t keyframe_id, double priority) {
    Transaction transaction(rig.store);
    ASSERT_TRUE(transaction.begin().ok());
    KeyframeRecord keyframe{.id = keyframe_id, .frame_id = keyframe_id, .strip_id = 1};
    ASSERT_TRUE(put(rig.store, keyframe).ok());
    ProductRecord product{
        .id = product_id(keyframe_id, ProductKind::image), .keyframe_id = keyframe_id, .priority = priority};
    product.bytes = product.data.bytes = 6000;
    const Bytes bytes = rig.noise(product.bytes);
    product.crc32 = crc32(bytes);
    ASSERT_TRUE(put(rig.store, product).ok());
    ASSERT_TRUE(write_blob<ProductRecord>(rig.store, "data", product.id, 0, bytes).ok());
    ASSERT_TRUE(transaction.commit().ok());
  }
  void fly_to(double time_s) {
    while (rig.now_s() < time_s) {
      rig.step();
      const bool turn = frames++ % 5 == 0;
      for (bool pending = turn; pending;) {
        const StepResult result = downlink->step();
        EXPECT_TRUE(result.status.ok()) << status_name(result.status.code);
        pending = result.pending;
      }
      beginnings.look(rig.store);
    }
  }

  DeliveryRig rig;
  std::unique_ptr<Downlink> downlink =
      std::make_unique<Downlink>(rig.store, rig.board->queue, rig.clock, rig.mission, test::step_memory<Downlink>());
  Beginnings beginnings;
  std::vector<std::string> arrived;
  int frames = 0;
};

TEST_P(BroadcastOrder, ABetterProductOvertakesAllThatHaveNotBegunAndEveryPassIsOrderedAnew) {
  constexpr int products = 30;
  // Neither the order of keyframes nor its reverse.
  const auto priority = [](int k) { return 0.3 + 0.01 * ((7 * k) % products); };
  for (int k = 1; k <= products; ++k) add(k, priority(k));
  std::vector<std::string> plan;
  for (int place = products - 1; place >= 0; --place) {
    for (int k = 1; k <= products; ++k) {
      if ((7 * k) % products == place) plan.push_back(name_of(k));
    }
  }
  fly_to(25);
  const std::size_t begun_in_pass = beginnings.all.size();
  ASSERT_GT(begun_in_pass, 2U);
  add(products + 1, 0.9);
  fly_to(60);
  const std::size_t begun_before_pass = beginnings.all.size();
  ASSERT_LT(begun_before_pass, static_cast<std::size_t>(products));
  add(products + 2, 0.8);
  fly_to(600);
  ASSERT_EQ(beginnings.all.size(), static_cast<std::size_t>(products + 2));

  // What has less than a second of the link before it has been chosen already.
  const auto overtaking = std::find(beginnings.all.begin(), beginnings.all.end(), name_of(products + 1));
  const auto place = static_cast<std::size_t>(overtaking - beginnings.all.begin());
  EXPECT_LE(place, begun_in_pass + 1);
  EXPECT_EQ(beginnings.all[begun_before_pass], name_of(products + 2)) << "the second pass is ordered again";
  plan.insert(plan.begin() + static_cast<std::ptrdiff_t>(place), name_of(products + 1));
  plan.insert(plan.begin() + static_cast<std::ptrdiff_t>(begun_before_pass), name_of(products + 2));
  EXPECT_EQ(beginnings.all, plan);
  // What is lost comes again, after what has begun meanwhile.
  if (GetParam() == 0) {
    EXPECT_EQ(arrived, plan) << "at the ground";
  }
  EXPECT_EQ(arrived.size(), plan.size());
}

TEST_P(BroadcastOrder, RestartsDoNotChangeTheOrder) {
  constexpr int products = 12;
  for (int k = 1; k <= products; ++k) add(k, 0.3 + 0.01 * k);
  std::vector<std::string> plan;
  for (int k = products; k >= 1; --k) plan.push_back(name_of(k));
  for (int boot = 1; boot <= 200; ++boot) {
    fly_to(3.7 * boot);
    downlink.reset();
    rig.reboot();
    downlink =
        std::make_unique<Downlink>(rig.store, rig.board->queue, rig.clock, rig.mission, test::step_memory<Downlink>());
    ASSERT_TRUE(downlink->restore().ok());
  }
  // Where the ground has ended a transaction that it did not know any more, its file goes again after the others.
  if (GetParam() == 0) {
    EXPECT_EQ(beginnings.all.size(), plan.size());
  }
  beginnings.all.resize(plan.size());
  EXPECT_EQ(beginnings.all, plan);
  EXPECT_EQ(std::set<std::string>(arrived.begin(), arrived.end()).size(), plan.size());
}

TEST_P(BroadcastOrder, TheLinkDoesNotRunDry) {
  rig.mission.pass_period_s = 0;
  for (int k = 1; k <= 40; ++k) add(k, 0.5);
  while (arrived.size() < 40 && rig.now_s() < 300) fly_to(rig.now_s() + 0.1);
  double bytes = 0;
  for (const DownlinkRecord& sent : records_of<DownlinkRecord>(rig.store)) bytes += sent.bytes;
  // As long as with all files in the queue at once. Headers take 5 %; of what is lost, the ends cost timers.
  const double most = GetParam() == 0 ? 1.08 : 2.2;
  EXPECT_LE(rig.now_s(), most * bytes / rig.mission.link_bytes_per_s) << bytes;
}

INSTANTIATE_TEST_SUITE_P(Losses, BroadcastOrder, testing::Values(0, 0.3));

/// A whole flight over packets, in virtual time.
class BroadcastFlight : public testing::Test {
 protected:
  static constexpr TimeNs longest_flight_ns = 1000 * ns_per_s;

  struct Waiting {
    double efficiency = 0;
    TimeNs since_ns = 0;
    double bytes = 0;
  };

  /// The products of which nothing has been handed over, whose keyframe's records have been.
  void look_at_waiting(TimeNs now) {
    std::int64_t records_through = 0;
    for (const DownlinkRecord& sent : records_of<DownlinkRecord>(store))
      records_through = std::max(records_through, sent.records_through);
    for (const ProductRecord& product : records_of<ProductRecord>(store)) {
      const bool waits = product.state == ProductState::stored && product.layers_sent == 0;
      if (!waits || product.keyframe_id > records_through) {
        waiting.erase(product.id);
        continue;
      }
      waiting.emplace(product.id, Waiting{efficiency_of(product), now, static_cast<double>(product.bytes)});
    }
  }
  double efficiency_of(const ProductRecord& product) {
    RichnessRecord richness;
    EXPECT_TRUE(get(store, product.keyframe_id, richness).ok());
    ProductUtility utility;
    utility.richness = product.priority;
    utility.newly_seen_share = richness.mask_fraction;
    utility.newly_seen_px = richness.mask_fraction * 640 * 480;
    return utility_of_layers(product, utility, layers_of(product)) / bytes_to(product, layers_of(product));
  }
  ProductRecord product_named(const std::string& name) {
    ProductRecord product;
    const std::int64_t keyframe = std::stoll(name.substr(8, 6));
    const bool depth = name.find("depth") != std::string::npos;
    EXPECT_TRUE(get(store, product_id(keyframe, depth ? ProductKind::depth : ProductKind::image), product).ok());
    return product;
  }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{48} << 20U);
  RamStore store{region};
  std::map<std::int64_t, Waiting> waiting;
};

double bytes_left_of_pass(const MissionParameters& mission, TimeNs now) {
  const double since_begin_s = std::fmod(1e-9 * static_cast<double>(now), mission.pass_period_s);
  return mission.link_bytes_per_s * std::max(0.0, mission.pass_length_s - since_begin_s);
}

TEST_F(BroadcastFlight, OverTwoPercentOfTheRawBitsProductsArriveInTheOrderOfTheirWorth) {
  MissionParameters mission;
  mission.window_keyframes = 3;
  mission.corners = 300;
  mission.quality_layers = 1;
  // 14 images of 160 x 120 px, one every half second: 38.4 kB/s.
  mission.link_bytes_per_s = 768;
  mission.pass_period_s = 60;
  mission.pass_length_s = 40;
  StillClock clock;
  RecordedCamera camera;
  ConfirmingLink unused;
  const auto station = std::make_unique<faults::PacketGround>(clock);
  FlightKit flight({store, camera, unused, clock, &station->packets(), &station->files()}, mission);
  ASSERT_TRUE(flight.start(recorded_camera()).ok());

  Beginnings beginnings;
  std::vector<std::string> arrived;
  int overtaken = 0;
  TimeNs last_begun_ns = 0;
  for (TimeNs next_ns = 0; clock.now() < longest_flight_ns && !flight->drained();) {
    flight->executive().run_minor_frame(next_ns);
    for (const std::string& name : beginnings.look(store)) {
      const ProductRecord begun = product_named(name);
      const double efficiency = efficiency_of(begun);
      for (const auto& [id, other] : waiting) {
        if (id == begun.id) continue;
        if (id < begun.id) ++overtaken;
        // A second of the link has been chosen before, at the latest half a second after a product was made.
        if (clock.now() - other.since_ns < 2 * ns_per_s) continue;
        // Where both no longer fit behind that second into the rest of the pass, the plan takes what is worth most
        // together, which may be two smaller ones.
        const double left = bytes_left_of_pass(mission, clock.now()) - mission.link_bytes_per_s;
        if (other.bytes + begun.bytes > left) continue;
        EXPECT_LE(other.efficiency, efficiency)
            << "product " << id << " of " << other.bytes << " bytes waits, " << name << " of " << begun.bytes
            << " begins at " << clock.now() / ns_per_ms << " ms";
      }
      last_begun_ns = clock.now();
    }
    look_at_waiting(clock.now());
    station->listen([&](const std::string& name, const std::vector<std::uint8_t>&) {
      if (name.starts_with("product-")) arrived.push_back(name);
      return true;
    });
    next_ns = next_frame_begin(next_ns, clock.now());
    clock.sleep_until(next_ns);
  }
  EXPECT_TRUE(flight->drained());
  EXPECT_GT(last_begun_ns, 60 * ns_per_s) << "one pass was enough";
  EXPECT_GT(arrived.size(), 10U);
  EXPECT_GT(overtaken, 5) << "the plan's order is that of making";
  EXPECT_EQ(arrived, beginnings.all);
}

}  // namespace
}  // namespace ilp::test
