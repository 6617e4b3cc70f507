// What stands in the way of single files, of single classes of files, or of all of them for a while.
#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>

#include "cfg/link_shares.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/downlink/downlink.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/downlink/fake_link.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::FailingStore;
using test::FakeLink;
using test::StoreCall;

const Status passing{StatusCode::store_error, 10};

class DownlinkFaultsTest : public test::ComponentTest {
 protected:
  DownlinkFaultsTest() { EXPECT_TRUE(downlink->restore().ok()); }

  void add_keyframe(std::int64_t id, std::size_t product_bytes = 2000, std::size_t points_bytes = 500) {
    KeyframeRecord keyframe{.id = id, .frame_id = id, .strip_id = 1};
    write(keyframe);
    PoseRecord pose{.id = id};
    write(pose);
    MaskRecord mask{.id = id};
    mask.code.bytes = 40;
    write(mask, "code", Bytes(40, static_cast<std::uint8_t>(id)));
    StructureRecord structure{.id = id};
    structure.points.bytes = static_cast<std::uint32_t>(points_bytes);
    write(structure, "points", Bytes(points_bytes, 3));
    ProductRecord product{
        .id = product_id(id, ProductKind::image), .keyframe_id = id, .kind = ProductKind::image, .priority = 0.5};
    product.bytes = product.data.bytes = static_cast<std::uint32_t>(product_bytes);
    Bytes bytes(product_bytes, static_cast<std::uint8_t>(id));
    product.crc32 = crc32(bytes);
    write(product, "data", bytes);
  }
  void add_events(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      EventRecord event;
      event.id = ++events;
      event.time_ns = clock.now();
      write(event);
    }
  }
  static std::string name_of(const char* what, std::int64_t id, const char* end) {
    char name[40];
    std::snprintf(name, sizeof(name), "%s-%06d%s", what, static_cast<int>(id), end);
    return name;
  }
  static std::string product_name(std::int64_t id) { return name_of("product", id, "-image.jp2"); }
  static std::string records_name(std::int64_t id) { return name_of("records", id, ".ilp"); }
  static std::string points_name(std::int64_t id) { return name_of("points", id, ".ilp"); }
  [[nodiscard]] std::ptrdiff_t times(const std::string& name) const {
    return std::count(link.order.begin(), link.order.end(), name);
  }
  void fly(double seconds, bool confirming = false) {
    const TimeNs end = clock.now() + static_cast<TimeNs>(seconds * 1e9);
    while (clock.now() < end) {
      clock.set(clock.now() + ns_per_s / 2);
      for (int i = 0; i < 200; ++i) {
        const StepResult result = downlink->step();
        if (!result.status.ok()) said.push_back(result.status);
        if (!result.pending) break;
      }
      if (!confirming) continue;
      for (const std::string& name : link.order) link.confirm(name);
    }
  }
  [[nodiscard]] bool saw(StatusCode code) const {
    return std::any_of(said.begin(), said.end(), [&](const Status& status) { return status.is(code); });
  }
  void reboot() {
    downlink = std::make_unique<Downlink>(failing, link, clock, mission, test::step_memory<Downlink>());
    EXPECT_TRUE(downlink->restore().ok());
  }

  FailingStore failing{store};
  FakeLink link;
  std::int64_t events = 0;
  std::vector<Status> said;
  std::unique_ptr<Downlink> downlink =
      std::make_unique<Downlink>(failing, link, clock, mission, test::step_memory<Downlink>());
};

TEST_F(DownlinkFaultsTest, OneUnreadableProductStopsNeitherOthersNorConfirmations) {
  for (std::int64_t id = 1; id <= 6; ++id) add_keyframe(id);
  const std::int64_t hit = product_id(2, ProductKind::image);
  failing.judge_by([&](const FailingStore::Call& call) {
    return call.kind == StoreCall::read_blob && call.type == RecordType::product && call.id == hit ? passing : Status{};
  });
  fly(10, true);
  for (std::int64_t id = 1; id <= 6; ++id) {
    EXPECT_EQ(times(product_name(id)), id == 2 ? 0 : 1) << id;
    if (id != 2) {
      EXPECT_EQ(read<ProductRecord>(product_id(id, ProductKind::image)).state, ProductState::acknowledged) << id;
    }
  }
  EXPECT_TRUE(saw(StatusCode::file_set_aside));
  EXPECT_LE(said.size(), 2U) << "told once";
  EXPECT_FALSE(downlink->drained());
  // The fault passes: the product goes, once.
  failing.recover();
  fly(60, true);
  EXPECT_EQ(times(product_name(2)), 1);
  EXPECT_TRUE(downlink->drained());
}

TEST_F(DownlinkFaultsTest, WhateverCannotBeReadIsTriedAgainAndGivenUpInTheEnd) {
  struct Case {
    const char* what;
    RecordType type;
    StoreCall call;
    StatusCode reported;
  };
  std::int64_t id = 0;
  for (const Case& c :
       {Case{"the bytes of a product", RecordType::product, StoreCall::read_blob, StatusCode::product_damaged},
        Case{"a pose", RecordType::pose, StoreCall::get, StatusCode::records_incomplete},
        Case{"a keyframe", RecordType::keyframe, StoreCall::get, StatusCode::records_incomplete},
        Case{"a mask", RecordType::mask, StoreCall::read_blob, StatusCode::records_incomplete},
        Case{"points", RecordType::structure, StoreCall::read_blob, StatusCode::points_given_up}}) {
    for (const bool lasting : {false, true}) {
      SCOPED_TRACE(testing::Message() << c.what << (lasting ? ", damaged" : ", a fault that may pass"));
      said.clear();
      const std::int64_t hit = ++id;
      for (int i = 0; i < 3; ++i) add_keyframe(i == 0 ? hit : ++id);
      const std::int64_t row = c.type == RecordType::product ? product_id(hit, ProductKind::image) : hit;
      const Status fault =
          lasting ? Status{StatusCode::record_damaged, row, static_cast<std::int64_t>(c.type)} : passing;
      failing.judge_by([&](const FailingStore::Call& call) {
        return call.kind == c.call && call.type == c.type && call.id == row ? fault : Status{};
      });
      fly(10);
      for (std::int64_t other = hit + 1; other <= id; ++other) {
        EXPECT_EQ(times(product_name(other)) + times(records_name(other)) + times(points_name(other)), 3) << other;
      }
      EXPECT_EQ(saw(c.reported), lasting) << "three times are enough for what is damaged";
      for (int i = 0; i < 500 && !saw(c.reported); ++i) fly(20);
      EXPECT_TRUE(saw(c.reported));
      fly(20);
      EXPECT_EQ(times(records_name(hit)), 1);
      EXPECT_EQ(times(product_name(hit)), c.type == RecordType::product ? 0 : 1);
      EXPECT_EQ(times(points_name(hit)), c.type == RecordType::structure ? 0 : 1);
      failing.recover();
    }
  }
}

TEST_F(DownlinkFaultsTest, DamagedRecordsStopNoWalk) {
  for (std::int64_t id = 1; id <= 6; ++id) add_keyframe(id);
  add_events(200);
  failing.damage(RecordType::product, product_id(2, ProductKind::image));
  failing.damage(RecordType::keyframe, 3);
  failing.damage(RecordType::structure, 4);
  failing.damage(RecordType::event, 70);
  CommandRecord command{.id = 1};
  write(command);
  failing.damage(RecordType::command, 1);
  fly(300, true);
  for (std::int64_t id = 1; id <= 6; ++id) {
    EXPECT_EQ(times(product_name(id)), id == 2 ? 0 : 1) << id;
    EXPECT_EQ(times(records_name(id)), 1) << id;
    EXPECT_EQ(times(points_name(id)), id == 4 ? 0 : 1) << id;
  }
  EXPECT_GE(times("events-000003.ilp"), 1) << "all but one of the events are down";
  EXPECT_TRUE(saw(StatusCode::event_given_up));
  EXPECT_TRUE(saw(StatusCode::points_given_up));
}

TEST_F(DownlinkFaultsTest, ADamagedRecordOfAFileLetsWhatItCarriedGoAgain) {
  for (std::int64_t id = 1; id <= 4; ++id) add_keyframe(id);
  fly(10);
  std::int64_t hit = 0;
  for (const DownlinkRecord& record : test::records_of<DownlinkRecord>(store)) {
    if (record.name == product_name(3)) hit = record.id;
  }
  ASSERT_NE(hit, 0);
  failing.damage(RecordType::downlink, hit);
  fly(60);
  EXPECT_GE(times(product_name(3)), 2);
  fly(60, true);
  for (std::int64_t id = 1; id <= 4; ++id) {
    EXPECT_EQ(read<ProductRecord>(product_id(id, ProductKind::image)).state, ProductState::acknowledged) << id;
  }
  EXPECT_TRUE(downlink->drained());
}

TEST_F(DownlinkFaultsTest, AStoreThatFailsForAMinuteConfirmsNothingEarlyLosesNothingAndSendsNothingTwice) {
  std::mt19937 random(3);
  std::int64_t id = 0;
  for (const int share : {100, 50, 10}) {
    SCOPED_TRACE(share);
    const std::size_t before = link.order.size();
    for (int i = 0; i < 20; ++i) add_keyframe(++id);
    fly(0.5);
    failing.judge_by([&](const FailingStore::Call& call) {
      // If a commit fails after the link has taken its file, the file can only be sent again.
      const bool hit = call.kind != StoreCall::commit && static_cast<int>(random() % 100) < share;
      return hit ? passing : Status{};
    });
    fly(60, true);
    failing.recover();
    fly(3000, true);
    for (std::int64_t one = id - 19; one <= id; ++one) {
      EXPECT_EQ(read<ProductRecord>(product_id(one, ProductKind::image)).state, ProductState::acknowledged) << one;
      EXPECT_LE(times(product_name(one)) + times(records_name(one)) + times(points_name(one)), share == 100 ? 3 : 6);
    }
    if (share == 100) {
      EXPECT_EQ(link.order.size() - before, 60U);
    }
    EXPECT_FALSE(saw(StatusCode::product_damaged) || saw(StatusCode::records_incomplete) ||
                 saw(StatusCode::points_given_up));
    EXPECT_TRUE(downlink->drained());
  }
}

TEST_F(DownlinkFaultsTest, FilesThatTheLinkDoesNotTakeWaitAndAreNeverGivenUp) {
  for (std::int64_t id = 1; id <= 3; ++id) add_keyframe(id);
  link.disk_full = true;
  fly(3600);
  EXPECT_TRUE(link.order.empty());
  link.disk_full = false;
  fly(3700, true);
  EXPECT_EQ(link.order.size(), 9U);
  EXPECT_FALSE(saw(StatusCode::product_damaged) || saw(StatusCode::records_incomplete));
  EXPECT_TRUE(downlink->drained());
}

TEST_F(DownlinkFaultsTest, RecordsPointsAndEventsWhoseConfirmationIsOverdueGoAgain) {
  mission.confirmation_timeout_s = 100;
  for (std::int64_t id = 1; id <= 3; ++id) add_keyframe(id);
  add_events(64);
  fly(20);
  const std::vector<std::string> lost{records_name(2), points_name(3), "events-000001.ilp"};
  for (const std::string& name : lost) EXPECT_EQ(times(name), 1) << name;
  const Bytes first = link.files[records_name(2)];
  for (const std::string& name : link.order) {
    if (std::find(lost.begin(), lost.end(), name) == lost.end()) link.confirm(name);
  }
  // The mission time of what is sent shows how long they have waited.
  for (int i = 0; i < 3; ++i) {
    add_keyframe(4 + i);
    fly(60);
    link.confirm(records_name(4 + i));
    link.confirm(points_name(4 + i));
    link.confirm(product_name(4 + i));
  }
  reboot();
  fly(30);
  EXPECT_EQ(times(records_name(2)), 2);
  EXPECT_EQ(link.files[records_name(2)].size(), first.size()) << "with its mask and its pose";
  EXPECT_EQ(times(points_name(3)), 2);
  EXPECT_EQ(times("events-000002.ilp"), 1) << "the same events under the next number";
  EXPECT_TRUE(saw(StatusCode::file_lost));
  EXPECT_EQ(times(records_name(1)), 1) << "what was confirmed does not go again";
  fly(30, true);
  EXPECT_TRUE(downlink->drained());
}

TEST_F(DownlinkFaultsTest, EveryClassGetsItsShareOfALinkThatNeverEmptiesForSixHours) {
  mission.link_bytes_per_s = 200;
  std::map<std::string, std::size_t> bytes;
  std::map<std::string, TimeNs> latest;
  TimeNs longest = 0;
  std::size_t total = 0;
  std::int64_t id = 0;
  std::size_t seen = 0;
  for (int second = 0; second < 6 * 3600; ++second) {
    // Each class alone would fill a quarter of the link or more; all together more than twice of it.
    if (second % 20 == 0) add_keyframe(++id, 4000, 2000);
    if (second % 2 == 0) add_events(1);
    clock.set(second * ns_per_s);
    run(*downlink);
    for (; seen < link.order.size(); ++seen) {
      const std::string& name = link.order[seen];
      const std::string what = name.substr(0, name.find('-')) == "refine" ? "product" : name.substr(0, name.find('-'));
      const std::size_t size = link.files[name].size();
      bytes[what] += size;
      total += size;
      longest = std::max(longest, clock.now() - latest[what]);
      latest[what] = clock.now();
    }
  }
  ASSERT_GT(total, 4'000'000U) << "saturated";
  constexpr std::size_t largest_file = 10'000;
  for (const auto& [what, kind] : std::map<std::string, FileClass>{{"product", FileClass::products},
                                                                   {"records", FileClass::records},
                                                                   {"points", FileClass::points},
                                                                   {"events", FileClass::events}}) {
    const auto share = static_cast<std::size_t>(link_share_permille[static_cast<std::size_t>(kind)]);
    std::printf("%-8s %5.1f %% of %zu bytes, at least %.1f %%\n", what.c_str(),
                100.0 * static_cast<double>(bytes[what]) / static_cast<double>(total), total,
                0.1 * static_cast<double>(share));
    // Records have no more to send than they are.
    const std::size_t wanted =
        kind == FileClass::records ? std::min(total * share / 1000, 40'000'000UL) : total * share / 1000;
    EXPECT_GE(bytes[what] + largest_file, wanted) << what;
  }
  // The least share of 10 bytes a second fills a file of 8000 bytes in 800 s.
  EXPECT_LT(longest, 1800 * ns_per_s) << "no class was silent for longer";
}

/// The number of a parameter in [downlink], and whether it is at its maximum or its minimum.
class DownlinkBoundariesTest : public DownlinkFaultsTest,
                               public testing::WithParamInterface<std::tuple<std::size_t, bool>> {};

TEST_P(DownlinkBoundariesTest, FilesGoWithEveryParameterAtItsBoundaries) {
  const auto [place, at_maximum] = GetParam();
  std::size_t index = 0;
  for (std::size_t i = 0, seen = 0; i < parameter_count(); ++i) {
    if (std::string(parameter_info(i).section) == "downlink" && seen++ == place) index = i;
  }
  const ParameterInfo& info = parameter_info(index);
  const double value = at_maximum ? info.maximum : info.minimum;
  SCOPED_TRACE(testing::Message() << info.key << " = " << value);
  ASSERT_TRUE(set_parameter(mission, index, value).ok());
  if (mission.pass_period_s > 0 || mission.pass_length_s != 600) mission.pass_period_s = 1e7;
  clock.set(static_cast<TimeNs>(mission.pass_start_s * 1e9));
  for (std::int64_t id = 1; id <= 4; ++id) add_keyframe(id);
  fly(30);
  EXPECT_EQ(link.order.size(), mission.link_bytes_per_s <= 0 ? 0U : 12U);
}

INSTANTIATE_TEST_SUITE_P(All, DownlinkBoundariesTest,
                         testing::Combine(testing::Range<std::size_t>(0, 8), testing::Bool()));

TEST_F(DownlinkFaultsTest, AFastLinkInALongPassDoesNotOverflow) {
  mission.link_bytes_per_s = 1e9;
  mission.pass_period_s = mission.pass_length_s = 1e7;
  for (std::int64_t id = 1; id <= 3; ++id) add_keyframe(id);
  fly(10);
  for (std::int64_t id = 1; id <= 3; ++id) EXPECT_EQ(times(product_name(id)), 1);
}

TEST_F(DownlinkFaultsTest, ALinkOfLessThanAByteASecondDoesNotStandStillForGood) {
  mission.link_bytes_per_s = 0.5;
  add_keyframe(1, 20, 20);
  fly(8000);
  EXPECT_EQ(link.order.size(), 3U);
}

TEST_F(DownlinkFaultsTest, BehindAnOlderCheckpointNumbersGoOnBehindWhatIsOnRecord) {
  for (std::int64_t id = 1; id <= 3; ++id) add_keyframe(id);
  add_events(64);
  fly(10);
  const std::size_t before = link.order.size();
  // The checkpoint is lost; what was sent is on record.
  test::erase_records<CheckpointRecord>(store);
  reboot();
  add_keyframe(4);
  fly(30, true);
  for (std::int64_t id = 1; id <= 4; ++id) {
    EXPECT_EQ(times(product_name(id)), 1) << id;
    EXPECT_EQ(times(records_name(id)), 1) << id;
  }
  EXPECT_EQ(times("events-000001.ilp"), 1) << "the number is in use";
  EXPECT_GT(link.order.size(), before);
  EXPECT_TRUE(downlink->drained());
}

}  // namespace
}  // namespace ilp
