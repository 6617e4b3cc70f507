// What the ground is told is on the disk before.
#include "bsp/flight/committed_links.hpp"

#include <gtest/gtest.h>

#include <string>

#include "hal/store/ram/ram_store.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

/// Everything that happens, in its order: f for a synchronisation, o for one of what this process has committed, e for
/// the end of a file, p for a packet.
std::string happened;

class Sharing final : public StoreSharing {
 public:
  Status claim(StageMask) override { return {}; }
  void release() override {}
  [[nodiscard]] bool connected() const override { return true; }
  Status reconnect() override { return {}; }
  Status flush() override {
    if (answer.ok()) happened += 'f';
    return answer;
  }
  Status flush_own() override {
    happened += 'o';
    return {};
  }
  void wait(std::int32_t) override {}

  Status answer;
};

class Files final : public Link {
 public:
  Status begin_file(const char*) override { return {}; }
  Status write(std::span<const std::uint8_t>) override { return {}; }
  Status end_file() override {
    happened += 'e';
    return {};
  }
  Status acknowledged(const char*, std::uint32_t&, std::uint32_t&) override { return StatusCode::not_ready; }
};

class Packets final : public PacketLink {
 public:
  Status receive(std::span<std::uint8_t>, std::size_t&) override { return StatusCode::not_ready; }
  Status send(std::span<const std::uint8_t>) override {
    happened += 'p';
    return {};
  }
};

class CommittedLinks : public testing::Test {
 protected:
  CommittedLinks() { happened.clear(); }
  void read() {
    FrameRecord frame;
    static_cast<void>(get(shared_, 1, frame));
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(1 << 20);
  RamStore store_{memory_};
  SharedFlightStore shared_{store_};
  Sharing sharing_;
  Files files_;
  Packets packets_;
  CommittedLink link_{files_, shared_, sharing_};
  CommittedPacketLink packet_link_{&packets_, shared_, sharing_};
};

TEST_F(CommittedLinks, WhatWasReadIsSynchronisedBeforeItIsTold) {
  read();
  ASSERT_OK(link_.begin_file("a"));
  ASSERT_OK(link_.end_file());
  EXPECT_EQ(happened, "fe");
  read();
  ASSERT_OK(packet_link_.send({}));
  ASSERT_OK(packet_link_.send({}));
  EXPECT_EQ(happened, "fefpp") << "nothing was read between the packets";
}

TEST_F(CommittedLinks, EveryWayOfReadingCounts) {
  FrameRecord frame;
  std::int64_t count = 0;
  std::uint8_t byte = 0;
  const RecordInfo& info = record_info<FrameRecord>();
  static_cast<void>(next(shared_, 0, frame));
  ASSERT_OK(packet_link_.send({}));
  static_cast<void>(last(shared_, frame));
  ASSERT_OK(packet_link_.send({}));
  static_cast<void>(shared_.count(info, count));
  ASSERT_OK(packet_link_.send({}));
  static_cast<void>(read_blob<FrameRecord>(shared_, "image", 1, 0, {&byte, 1}));
  ASSERT_OK(packet_link_.send({}));
  EXPECT_EQ(happened, "fpfpfpfp");
}

TEST_F(CommittedLinks, WhatWasCommittedCountsToo) {
  ASSERT_OK(shared_.begin());
  ASSERT_OK(put(shared_, FrameRecord{}));
  ASSERT_OK(shared_.commit());
  ASSERT_OK(packet_link_.send({}));
  EXPECT_EQ(happened, "fp");
}

TEST_F(CommittedLinks, WhatTakesLongIsDoneBeforeTheTransaction) {
  link_.prepare();
  EXPECT_EQ(happened, "o");
}

TEST_F(CommittedLinks, WhatCannotBeSynchronisedIsNotTold) {
  sharing_.answer = StatusCode::store_error;
  read();
  ASSERT_OK(link_.begin_file("a"));
  EXPECT_STATUS(link_.end_file(), not_ready);
  EXPECT_STATUS(packet_link_.send({}), not_ready);
  EXPECT_EQ(happened, "");
  sharing_.answer = {};
  ASSERT_OK(link_.end_file());
  EXPECT_EQ(happened, "fe");
}

}  // namespace
}  // namespace ilp
