#include <algorithm>
#include <map>
#include <memory>
#include <string>

#include "fsw/base/crc.hpp"
#include "fsw/downlink/downlink.hpp"
#include "fsw/records/serial.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/downlink/fake_link.hpp"
#include "tests/unit/executive/refusing_store.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::FakeLink;

class DownlinkTest : public test::ComponentTest {
 protected:
  DownlinkTest() { EXPECT_TRUE(downlink->restore().ok()); }

  void add_keyframe(std::int64_t id) {
    KeyframeRecord keyframe{.id = id, .frame_id = id, .strip_id = 1};
    write(keyframe);
  }
  Bytes content(std::int64_t id, std::size_t size) {
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + static_cast<std::size_t>(id));
    return bytes;
  }
  void add_product(std::int64_t keyframe_id, ProductKind kind, double priority, std::size_t size = 5000) {
    ProductRecord product;
    product.id = product_id(keyframe_id, kind);
    product.keyframe_id = keyframe_id;
    product.kind = kind;
    product.priority = priority;
    product.bytes = static_cast<std::uint32_t>(size);
    product.data.bytes = product.bytes;
    const Bytes bytes = content(product.id, size);
    product.crc32 = crc32(bytes);
    write(product, "data", bytes);
  }
  void reboot() {
    downlink = std::make_unique<Downlink>(store, link, clock, mission, test::step_memory<Downlink>());
    ASSERT_TRUE(downlink->restore().ok());
  }
  std::ptrdiff_t place(const std::string& name) {
    const auto found = std::find(link.order.begin(), link.order.end(), name);
    EXPECT_NE(found, link.order.end()) << name << " was not sent";
    return found - link.order.begin();
  }

  FakeLink link;
  std::unique_ptr<Downlink> downlink =
      std::make_unique<Downlink>(store, link, clock, mission, test::step_memory<Downlink>());
};

TEST_F(DownlinkTest, RecordsGoBeforeProductsAndProductsByPriority) {
  for (std::int64_t id = 1; id <= 3; ++id) add_keyframe(id);
  add_product(1, ProductKind::depth, 0.301);
  add_product(1, ProductKind::image, 0.3);
  add_product(2, ProductKind::depth, 0.901);
  add_product(2, ProductKind::image, 0.9);
  add_product(3, ProductKind::image, 0.6);
  clock.set(ns_per_s);
  EXPECT_TRUE(run(*downlink).empty());
  EXPECT_EQ(link.order, (std::vector<std::string>{"records-000001.ilp", "records-000002.ilp", "records-000003.ilp",
                                                  "product-000002-depth.jp2", "product-000002-image.jp2",
                                                  "product-000003-image.jp2", "product-000001-depth.jp2",
                                                  "product-000001-image.jp2"}));
  EXPECT_EQ(link.files["product-000002-image.jp2"], content(product_id(2, ProductKind::image), 5000));
  EXPECT_EQ(read<ProductRecord>(product_id(2, ProductKind::image)).state, ProductState::sent);
}

TEST_F(DownlinkTest, ADepthMapWaitsForTheRecordsOfItsKeyframe) {
  add_keyframe(1);
  add_product(1, ProductKind::depth, 0.5);  // its image is still being coded
  clock.set(ns_per_s);
  run(*downlink);
  EXPECT_TRUE(link.order.empty());
  add_product(1, ProductKind::image, 0.5);
  run(*downlink);
  EXPECT_EQ(place("records-000001.ilp"), 0);
}

TEST_F(DownlinkTest, TheMeanRateOfTheLinkIsKept) {
  mission.link_bytes_per_s = 1000;
  constexpr std::size_t size = 5000;
  for (std::int64_t id = 1; id <= 8; ++id) {
    add_keyframe(id);
    add_product(id, ProductKind::image, 0.5, size);
  }
  for (int tenth = 0; tenth <= 900; ++tenth) {
    clock.set(tenth * 100 * ns_per_ms);
    run(*downlink);
    // One file may be begun whenever nothing is owed.
    EXPECT_LE(link.total_bytes, static_cast<std::size_t>(100 * tenth) + size) << "at " << 0.1 * tenth << " s";
  }
  EXPECT_EQ(read<ProductRecord>(product_id(8, ProductKind::image)).state, ProductState::sent);
}

TEST_F(DownlinkTest, AnIdleLinkSavesNoMoreThanTenSeconds) {
  mission.link_bytes_per_s = 1000;
  clock.set(3600 * ns_per_s);
  run(*downlink);
  for (std::int64_t id = 1; id <= 12; ++id) {
    add_keyframe(id);
    add_product(id, ProductKind::image, 0.5, 5000);
  }
  run(*downlink);
  EXPECT_LE(link.total_bytes, 10'000U + 5000U);
  EXPECT_GT(link.total_bytes, 9000U);
}

TEST_F(DownlinkTest, TheNextFileIsChosenWhenTheLinkHasLessThanASecondToSend) {
  mission.link_bytes_per_s = 1000;
  for (std::int64_t id = 1; id <= 2; ++id) {
    add_keyframe(id);
    add_product(id, ProductKind::image, 0.5);
  }
  // Half a minute in which the link has other things to send.
  link.unsent_bytes = 1000;
  for (int half = 0; half < 60; ++half) {
    clock.set(half * ns_per_s / 2);
    EXPECT_TRUE(run(*downlink).empty());
    EXPECT_FALSE(downlink->drained());
  }
  EXPECT_TRUE(link.order.empty());
  add_keyframe(3);
  add_product(3, ProductKind::image, 0.9);
  link.unsent_bytes = 999;
  for (int half = 60; half < 72; ++half) {
    clock.set(half * ns_per_s / 2);
    run(*downlink);
  }
  EXPECT_EQ(place("product-000003-image.jp2"), 3) << "behind the three files of records";
  EXPECT_LE(link.total_bytes, 6000U + 5000U) << "the time is not saved up";
}

TEST_F(DownlinkTest, WhatTheLinkHasNotSentTakesRoomInAPass) {
  mission.link_bytes_per_s = 1000;
  mission.pass_period_s = 60;
  mission.pass_length_s = 10;
  add_keyframe(1);
  add_product(1, ProductKind::image, 0.5, 900);
  clock.set(0);
  run(*downlink);
  ASSERT_EQ(link.order, (std::vector<std::string>{"records-000001.ilp"}));
  link.unsent_bytes = 1000;
  clock.set(9 * ns_per_s);
  run(*downlink);
  // Of the second that is left, 0.2 s are taken.
  link.unsent_bytes = 200;
  clock.set(9 * ns_per_s + 100 * ns_per_ms);
  run(*downlink);
  EXPECT_EQ(link.order.size(), 1U) << "it would not be through before the pass ends";
  link.unsent_bytes = 0;
  run(*downlink);
  EXPECT_EQ(link.order.size(), 2U);
}

TEST_F(DownlinkTest, WithoutALinkNothingIsSent) {
  mission.link_bytes_per_s = 0;
  add_keyframe(1);
  add_product(1, ProductKind::image, 0.5);
  clock.set(100 * ns_per_s);
  run(*downlink);
  EXPECT_TRUE(link.order.empty());
  EXPECT_EQ(read<ProductRecord>(product_id(1, ProductKind::image)).state, ProductState::stored);
}

TEST_F(DownlinkTest, AProductThatChangedInTheStoreIsReportedAndNotSent) {
  add_keyframe(1);
  add_product(1, ProductKind::depth, 0.6);
  add_product(1, ProductKind::image, 0.5);
  const std::int64_t hit = product_id(1, ProductKind::depth);
  {
    const std::uint8_t flipped = static_cast<std::uint8_t>(content(hit, 5000)[4567] ^ 0x10U);
    test::in_transaction(store, [&] {
      ASSERT_TRUE(write_blob<ProductRecord>(store, "data", hit, 4567, {&flipped, 1}).ok());
    });
  }
  clock.set(ns_per_s);
  const std::vector<Status> events = run(*downlink);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].code, StatusCode::product_damaged);
  EXPECT_EQ(events[0].a, hit);
  EXPECT_EQ(link.files.count("product-000001-depth.jp2"), 0U);
  EXPECT_EQ(link.files.count("product-000001-image.jp2"), 1U) << "the others go on";
  EXPECT_EQ(read<ProductRecord>(hit).state, ProductState::dropped);
}

TEST_F(DownlinkTest, OnlyARightConfirmationCounts) {
  add_keyframe(1);
  add_product(1, ProductKind::image, 0.5);
  clock.set(ns_per_s);
  run(*downlink);
  const std::string name = "product-000001-image.jp2";
  const std::int64_t id = product_id(1, ProductKind::image);
  link.confirm("records-000001.ilp");
  const auto right = std::make_pair(static_cast<std::uint32_t>(link.files[name].size()), crc32(link.files[name]));

  link.confirmed[name] = {right.first, right.second ^ 1U};
  run(*downlink);
  EXPECT_EQ(read<ProductRecord>(id).state, ProductState::sent);
  link.confirmed[name] = {right.first - 1, right.second};
  run(*downlink);
  EXPECT_EQ(read<ProductRecord>(id).state, ProductState::sent);
  EXPECT_FALSE(downlink->drained());

  link.confirmed[name] = right;
  clock.set(5 * ns_per_s);
  run(*downlink);
  EXPECT_EQ(read<ProductRecord>(id).state, ProductState::acknowledged);
  EXPECT_EQ(read<DownlinkRecord>(2).acknowledged_ns, 5 * ns_per_s);
  EXPECT_TRUE(downlink->drained());
}

TEST_F(DownlinkTest, ConfirmationsAreHeardInAnyOrderHoweverManyAreMissing) {
  constexpr std::int64_t keyframes = 40;
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    add_keyframe(id);
    add_product(id, ProductKind::image, 0.5, 100);
  }
  clock.set(ns_per_s);
  run(*downlink);
  for (std::int64_t id = keyframes; id > 20; --id) {
    char name[32];
    std::snprintf(name, sizeof(name), "product-%06d-image.jp2", static_cast<int>(id));
    link.confirm(name);
  }
  for (int i = 0; i < 20; ++i) run(*downlink);
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(read<ProductRecord>(product_id(id, ProductKind::image)).state,
              id > 20 ? ProductState::acknowledged : ProductState::sent)
        << id;
  }
  for (const std::string& name : link.order) link.confirm(name);
  for (int i = 0; i < 20; ++i) run(*downlink);
  EXPECT_TRUE(downlink->drained());
}

TEST_F(DownlinkTest, AFileThatTheLinkCannotTakeIsNotOnRecordAndComesAgain) {
  add_keyframe(1);
  add_product(1, ProductKind::image, 0.5, 20'000);
  clock.set(ns_per_s);
  ASSERT_TRUE(downlink->step().status.ok());
  ASSERT_EQ(link.order, (std::vector<std::string>{"records-000001.ilp"}));
  link.writes_until_fault = 0;
  const StepResult failed = downlink->step();
  EXPECT_EQ(failed.status.code, StatusCode::file_set_aside);
  EXPECT_EQ(failed.status.b, static_cast<std::int64_t>(StatusCode::io_error));
  EXPECT_EQ(link.files.count("product-000001-image.jp2"), 0U) << "visible only whole";
  EXPECT_EQ(number_of<DownlinkRecord>(), 1);
  EXPECT_EQ(read<ProductRecord>(product_id(1, ProductKind::image)).state, ProductState::stored);

  run(*downlink);
  EXPECT_EQ(link.files["product-000001-image.jp2"], content(product_id(1, ProductKind::image), 20'000));
  EXPECT_EQ(number_of<DownlinkRecord>(), 2);
}

TEST_F(DownlinkTest, AfterARestartNothingIsSentTwiceOrForgotten) {
  for (std::int64_t id = 1; id <= 4; ++id) {
    add_keyframe(id);
    add_product(id, ProductKind::depth, 0.5 + 0.1 * static_cast<double>(id));
    add_product(id, ProductKind::image, 0.5);
  }
  clock.set(ns_per_s);
  for (int i = 0; i < 30; ++i) {
    reboot();
    ASSERT_TRUE(downlink->step().status.ok());
  }
  EXPECT_EQ(link.order.size(), 12U);
  EXPECT_EQ(link.files.size(), 12U);
}

TEST_F(DownlinkTest, AClockThatBeginsAgainDoesNotSilenceTheLink) {
  mission.link_bytes_per_s = 1000;
  clock.set(100'000 * ns_per_s);
  add_keyframe(1);
  add_product(1, ProductKind::image, 0.5, 20'000);
  run(*downlink);
  ASSERT_EQ(place("product-000001-image.jp2"), 1);
  clock.set(0);
  reboot();
  add_keyframe(2);
  add_product(2, ProductKind::image, 0.5, 1000);
  for (int second = 0; second < 60; ++second) {
    clock.set(second * ns_per_s);
    run(*downlink);
  }
  EXPECT_EQ(read<ProductRecord>(product_id(2, ProductKind::image)).state, ProductState::sent);
}

TEST_F(DownlinkTest, ARecordsFileEndsWithItsChecksumAndCarriesTheMaskButNoDepth) {
  add_keyframe(1);
  DepthRecord depth{.id = 1};
  depth.values.bytes = 600;
  depth.sigma.bytes = 300;
  write(depth);
  MaskRecord new_ground{.id = 1};
  new_ground.code.bytes = 5;
  const Bytes code{9, 8, 7, 6, 5};
  write(new_ground, "code", code);
  add_product(1, ProductKind::image, 0.5);
  clock.set(ns_per_s);
  run(*downlink);
  const Bytes& file = link.files["records-000001.ilp"];
  ASSERT_GT(file.size(), 13U);
  EXPECT_EQ(std::string(file.begin(), file.begin() + 4), "ILPR");
  std::uint32_t stated = 0;
  for (unsigned i = 0; i < 4; ++i) stated |= std::uint32_t{file[file.size() - 4 + i]} << (8 * i);
  EXPECT_EQ(stated, crc32({file.data(), file.size() - 4}));
  EXPECT_EQ(file[file.size() - 5], 255);

  // Walk over the entries: type, length, serial form, blobs.
  std::size_t at = 8;
  bool mask_found = false;
  while (file[at] != 255) {
    const auto type = static_cast<RecordType>(file[at]);
    const std::size_t length = file[at + 1] + std::size_t{256} * file[at + 2];
    at += 3;
    if (type == RecordType::depth) {
      DepthRecord sent;
      ASSERT_TRUE(deserialize(record_info<DepthRecord>(), {file.data() + at, length}, &sent).ok());
      EXPECT_EQ(sent.values.bytes, 0U);
      EXPECT_EQ(sent.sigma.bytes, 0U);
    }
    if (type == RecordType::mask) {
      MaskRecord sent;
      ASSERT_TRUE(deserialize(record_info<MaskRecord>(), {file.data() + at, length}, &sent).ok());
      ASSERT_EQ(sent.code.bytes, code.size());
      mask_found = std::equal(code.begin(), code.end(), file.begin() + static_cast<std::ptrdiff_t>(at + length));
      at += code.size();
    }
    at += length;
    ASSERT_LT(at, file.size());
  }
  EXPECT_TRUE(mask_found);
  EXPECT_EQ(at + 5, file.size());
}

TEST_F(DownlinkTest, WithoutAnImageTheRecordsTellWhatFrameItWas) {
  for (const std::int64_t id : {1, 2}) {
    add_keyframe(id);
    FrameRecord frame{.id = id};
    std::snprintf(frame.name, sizeof(frame.name), "img_%d.png", static_cast<int>(id));
    frame.image.bytes = 4;
    write(frame, "image", Bytes{1, 2, 3, 4});
    add_product(id, ProductKind::image, 0.5);
  }
  ProductRecord known = read<ProductRecord>(product_id(2, ProductKind::image));
  known.state = ProductState::dropped;
  known.bytes = known.data.bytes = 0;
  write(known);
  clock.set(ns_per_s);
  run(*downlink);
  const auto names = [&](const char* file, const std::string& frame) {
    const Bytes& bytes = link.files[file];
    return std::search(bytes.begin(), bytes.end(), frame.begin(), frame.end()) != bytes.end();
  };
  EXPECT_FALSE(names("records-000001.ilp", "img_1.png")) << "the image tells";
  EXPECT_TRUE(names("records-000002.ilp", "img_2.png"));
}

TEST_F(DownlinkTest, EventsAreSentInOrderAndOnce) {
  for (std::int64_t id = 1; id <= 150; ++id) {
    EventRecord event{.id = id};
    write(event);
  }
  clock.set(ns_per_s);
  run(*downlink);
  EXPECT_EQ(link.order, (std::vector<std::string>{"events-000001.ilp", "events-000002.ilp"})) << "64 a file";
  clock.set(200 * ns_per_s);
  run(*downlink);
  EXPECT_EQ(link.order.size(), 3U) << "the rest when time has passed";
  clock.set(900 * ns_per_s);
  run(*downlink);
  EXPECT_EQ(link.order.size(), 3U);
}

TEST_F(DownlinkTest, WithoutContactEverythingWaitsAndTheLossIsOneEvent) {
  add_keyframe(1);
  add_product(1, ProductKind::depth, 0.4);
  add_product(1, ProductKind::image, 0.5);
  link.contact = false;
  std::vector<Status> said;
  for (int second = 1; second <= 60; ++second) {
    clock.set(second * ns_per_s);
    for (const Status& status : run(*downlink)) said.push_back(status);
    EXPECT_FALSE(downlink->drained());
  }
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].code, StatusCode::link_lost);
  EXPECT_TRUE(link.order.empty());

  link.contact = true;
  clock.set(61 * ns_per_s);
  said = run(*downlink);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].code, StatusCode::link_restored);
  EXPECT_EQ(said[0].a, 60'000);
  EXPECT_EQ(link.order,
            (std::vector<std::string>{"records-000001.ilp", "product-000001-image.jp2", "product-000001-depth.jp2"}));
}

TEST_F(DownlinkTest, NothingIsSentThatTheStoreCouldNotRemember) {
  add_keyframe(1);
  add_product(1, ProductKind::image, 0.5);
  test::RefusingStore refusing(store);
  const auto careful = std::make_unique<Downlink>(refusing, link, clock, mission, test::step_memory<Downlink>());
  ASSERT_TRUE(careful->restore().ok());
  refusing.full = true;
  for (int second = 1; second <= 10; ++second) {
    clock.set(second * ns_per_s);
    for (const Status& status : run(*careful)) EXPECT_EQ(status.code, StatusCode::store_full);
  }
  EXPECT_TRUE(link.order.empty()) << "it would be sent again and again";
  refusing.full = false;
  clock.set(11 * ns_per_s);
  run(*careful);
  EXPECT_EQ(link.order, (std::vector<std::string>{"records-000001.ilp", "product-000001-image.jp2"}));
}

}  // namespace
}  // namespace ilp
