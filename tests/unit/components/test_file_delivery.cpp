#include "fsw/components/file_delivery.hpp"

#include <gtest/gtest.h>

#include <string>

#include "fsw/components/downlink.hpp"
#include "tests/support/delivery_rig.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::DeliveryRig;

class FileDeliveryTest : public testing::Test {
 protected:
  void wish(std::int64_t sequence, TransferWish what) {
    Transaction transaction(rig.store);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(wish_transfer(rig.store, sequence, what).ok());
    ASSERT_TRUE(transaction.commit().ok());
  }
  void steps(int number) {
    for (int i = 0; i < number; ++i) rig.step();
  }
  void send_to_board(const cfdp::Pdu& pdu) {
    Bytes bytes(4096);
    std::size_t size = 0;
    ASSERT_TRUE(cfdp::encode(pdu, bytes, size).ok());
    ASSERT_TRUE(rig.link->ground().send(std::span<const std::uint8_t>(bytes).first(size)).ok());
  }
  std::vector<Bytes> from_board() {
    std::vector<Bytes> pdus;
    Bytes buffer(8192);
    std::size_t bytes = 0;
    while (rig.link->ground().receive(buffer, bytes).ok()) {
      pdus.emplace_back(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(bytes));
    }
    return pdus;
  }
  static cfdp::Pdu finished(std::uint64_t sequence, std::uint64_t destination = 2) {
    cfdp::Pdu pdu;
    pdu.header = {true, false, false, false, false, false, 2, 2, 1, sequence, destination};
    pdu.kind = cfdp::PduKind::finished;
    pdu.finished.file_status = cfdp::FileStatus::retained;
    return pdu;
  }
  TransferRecord record() {
    TransferRecord found;
    EXPECT_TRUE(next(rig.store, 0, found).ok());
    return found;
  }

  DeliveryRig rig;
};

TEST_F(FileDeliveryTest, RecordsGoBeforeProductsAndOlderOnesFirst) {
  rig.mission.cfdp_open_transfers = 1;
  std::vector<std::string> order;
  rig.ground = std::make_unique<sim::CfdpReceiver>(
      rig.receiver, [this](const Bytes& pdu) { static_cast<void>(rig.link->ground().send(pdu)); },
      [&](const std::string& name, const Bytes& file) {
        order.push_back(name);
        rig.on_ground[name] = file;
        return true;
      });
  for (const char* name : {"product-1", "points-1", "records-1", "product-2", "events-1"}) {
    rig.offer(name, rig.noise(3000));
  }
  rig.run(200);
  EXPECT_EQ(order, (std::vector<std::string>{"records-1", "events-1", "product-1", "points-1", "product-2"}));
}

TEST_F(FileDeliveryTest, SuspendsResumesAndCancelsAsTheGroundWishes) {
  rig.offer("product-1", rig.noise(500000));
  steps(3);
  const std::int64_t sequence = record().sequence;
  ASSERT_NE(sequence, 0);
  wish(sequence, TransferWish::suspend);
  steps(8);
  const std::uint64_t before = rig.ground->counts().data_bytes;
  steps(100);
  EXPECT_EQ(rig.ground->counts().data_bytes, before);
  EXPECT_EQ(record().suspended, 1);
  rig.reboot();
  steps(100);
  EXPECT_EQ(rig.ground->counts().data_bytes, before) << "still suspended";
  wish(sequence, TransferWish::resume);
  steps(8);
  EXPECT_GT(rig.ground->counts().data_bytes, before);
  wish(0, TransferWish::cancel);
  steps(20);
  EXPECT_EQ(rig.transfers(), 0);
  EXPECT_TRUE(rig.confirmed.empty());
  EXPECT_TRUE(rig.saw(StatusCode::transfer_cancelled));
  EXPECT_TRUE(rig.on_ground.empty());
  EXPECT_EQ(rig.ground->open(), 0U) << "the ground knows that nothing will come";
  Transaction transaction(rig.store);
  ASSERT_TRUE(transaction.begin().ok());
  EXPECT_TRUE(wish_transfer(rig.store, 77, TransferWish::cancel).is(StatusCode::not_found));
}

TEST_F(FileDeliveryTest, AFileThatTheGroundCouldNotKeepGoesAgainAsANewTransaction) {
  rig.mission.cfdp_rest_s = 5;
  rig.ground_keeps = false;
  rig.offer("product-1", rig.noise(20000));
  steps(20);
  EXPECT_TRUE(rig.saw(StatusCode::transfer_refused));
  EXPECT_EQ(record().attempts, 1U);
  EXPECT_EQ(record().condition, 4);
  EXPECT_TRUE(rig.confirmed.empty());
  rig.ground_keeps = true;
  rig.run(200);
  EXPECT_EQ(rig.confirmed.size(), 1U);
}

TEST_F(FileDeliveryTest, EveryFinishedIsAcknowledgedAlsoOfTransactionsThatAreClosedOrUnknown) {
  rig.offer("product-1", rig.noise(2000));
  rig.run(100);
  steps(2);
  from_board();
  rig.ground_listens = false;
  for (const std::uint64_t sequence : {1U, 1U, 999U}) {
    send_to_board(finished(sequence));
    rig.step();
    const auto pdus = from_board();
    ASSERT_EQ(pdus.size(), 1U);
    cfdp::Pdu pdu;
    ASSERT_TRUE(cfdp::decode(pdus[0], pdu).ok());
    EXPECT_EQ(pdu.kind, cfdp::PduKind::ack);
    EXPECT_TRUE(pdu.ack.of_finished);
    EXPECT_FALSE(pdu.header.toward_sender);
    EXPECT_EQ(pdu.header.sequence, sequence);
    EXPECT_EQ(pdu.ack.status,
              sequence == 1 ? cfdp::TransactionStatus::terminated : cfdp::TransactionStatus::unrecognized);
  }
}

TEST_F(FileDeliveryTest, WithoutACommitTheGroundIsPromisedNothing) {
  rig.ground_listens = false;
  rig.offer("product-1", rig.noise(2000));
  steps(5);
  from_board();
  rig.refusing.full = true;
  send_to_board(finished(1));
  send_to_board(finished(1));
  rig.step();
  send_to_board(finished(1));
  rig.step();
  EXPECT_TRUE(from_board().empty());
  EXPECT_EQ(record().state, TransferState::sent);
  rig.refusing.full = false;
  rig.on_ground = rig.files;
  rig.step();
  EXPECT_EQ(from_board().size(), 1U);
  EXPECT_EQ(rig.confirmed.size(), 1U);
}

TEST_F(FileDeliveryTest, AnotherStationsFinishedDeliversNothing) {
  rig.ground_listens = false;
  rig.offer("product-1", rig.noise(2000));
  steps(5);
  EXPECT_EQ(record().state, TransferState::sent);
  send_to_board(finished(1, 3));
  steps(5);
  EXPECT_EQ(record().state, TransferState::sent);
  EXPECT_EQ(rig.sent.count("product-1"), 1U);
}

TEST_F(FileDeliveryTest, SequenceNumbersAreNotUsedAgainBehindARestart) {
  rig.ground_listens = false;
  rig.offer("product-1", rig.noise(2000));
  steps(3);
  EXPECT_EQ(record().sequence, 1);
  rig.ground_listens = true;
  rig.run(400);
  rig.reboot();
  rig.ground_listens = false;
  rig.offer("product-2", rig.noise(2000));
  steps(2);
  EXPECT_EQ(record().sequence, 2);
}

TEST_F(FileDeliveryTest, RubbishIsCountedAndToldOnceAMinute) {
  for (int i = 0; i < 300; ++i) {
    for (int k = 0; k < 5; ++k) {
      Bytes rubbish = rig.noise(7 + rig.random() % 60);
      rubbish[0] = static_cast<std::uint8_t>(0x20 | (rubbish[0] & 0x1F));
      ASSERT_TRUE(rig.link->ground().send(rubbish).ok());
    }
    rig.step();
  }
  EXPECT_GT(rig.board->delivery.counts().rejected, 1000U);
  EXPECT_EQ(rig.events.size(), 1U);
  rig.offer("product-1", rig.noise(20000));
  rig.run(100);
}

TEST_F(FileDeliveryTest, AFullQueueSaysLaterAndTakesMoreWhenTheGroundHasTakenSome) {
  rig.mission.cfdp_queue_kib = 100;
  for (int i = 0; i < 100; ++i) rig.offer("product-" + std::to_string(i), rig.noise(i % 2 == 0 ? 50000 : 10));
  rig.step();
  EXPECT_GE(rig.sent.size(), 3U);
  EXPECT_LE(rig.sent.size(), 5U);
  rig.run(2000);
  EXPECT_EQ(rig.confirmed.size(), 100U);
}

TEST_F(FileDeliveryTest, OfferedAgainUnderTheSameNameTheNewFileCounts) {
  rig.ground_listens = false;
  rig.offer("product-1", rig.noise(50000));
  steps(3);
  rig.offer("product-1", rig.noise(700));
  rig.ground_listens = true;
  steps(1);
  EXPECT_EQ(rig.transfers(), 1);
  rig.run(300);
  EXPECT_EQ(rig.on_ground["product-1"].size(), 700U);
}

TEST_F(FileDeliveryTest, WritesTheStoreNowAndThenNotForEverySegment) {
  rig.offer("product-1", rig.noise(1500000));
  int changes = 0;
  while (!rig.done()) {
    RecordMask changed = 0;
    ASSERT_TRUE(rig.store.poll(changed).ok());
    rig.step();
    ASSERT_TRUE(rig.store.poll(changed).ok());
    changes += (changed & mask_of(RecordType::transfer)) != 0 ? 1 : 0;
  }
  // 1500 segments.
  EXPECT_LT(changes, 12);
}

TEST_F(FileDeliveryTest, EveryChecksumWithPduCrcsAndLongSequenceNumbersIsUnderstood) {
  for (const double checksum : {0.0, 2.0, 3.0, 15.0}) {
    for (const double octets : {1.0, 4.0, 8.0}) {
      rig.mission.cfdp_checksum = checksum;
      rig.mission.cfdp_pdu_crc = 1;
      rig.mission.cfdp_sequence_octets = octets;
      rig.reboot();
      rig.offer("product-" + std::to_string(checksum) + std::to_string(octets), rig.noise(10001));
      rig.run(100);
    }
  }
  EXPECT_EQ(rig.confirmed.size(), 12U);
}

TEST_F(FileDeliveryTest, WithoutALinkItRests) {
  PacketRouter none(nullptr, nullptr, rig.clock, rig.mission);
  FileDelivery delivery(rig.store, none, rig.clock, rig.mission);
  ASSERT_TRUE(delivery.restore().ok());
  rig.ground_listens = false;
  EXPECT_TRUE(delivery.step(0).status.ok());
}

TEST_F(FileDeliveryTest, TheRealDownlinkQueuesItsFilesAndBelievesOnlyWhatArrived) {
  auto downlink = std::make_unique<Downlink>(rig.store, rig.board->queue, rig.clock, rig.mission);
  ASSERT_TRUE(downlink->restore().ok());
  rig.mission.cfdp_queue_kib = 40;
  Transaction transaction(rig.store);
  ASSERT_TRUE(transaction.begin().ok());
  for (std::int64_t k = 1; k <= 20; ++k) {
    KeyframeRecord keyframe;
    keyframe.id = keyframe.frame_id = k;
    keyframe.strip_id = 1;
    ASSERT_TRUE(put(rig.store, keyframe).ok());
    ProductRecord product;
    product.id = product_id(k, ProductKind::image);
    product.keyframe_id = k;
    product.priority = 0.5;
    product.bytes = product.data.bytes = 20000;
    const Bytes bytes = rig.noise(product.bytes);
    product.crc32 = crc32(bytes);
    ASSERT_TRUE(put(rig.store, product).ok());
    ASSERT_TRUE(write_blob<ProductRecord>(rig.store, "data", product.id, 0, bytes).ok());
  }
  ASSERT_TRUE(transaction.commit().ok());
  bool lost = false;
  for (int i = 0; i < 3000 && !downlink->drained(); ++i) {
    rig.step();
    for (bool pending = i % 5 == 0; pending;) {
      const StepResult result = downlink->step(0);
      lost = lost || result.status.is(StatusCode::link_lost);
      EXPECT_TRUE(result.status.ok()) << status_name(result.status.code);
      pending = result.pending;
    }
  }
  EXPECT_TRUE(downlink->drained());
  EXPECT_FALSE(lost) << "a full queue is no lost link";
  for (std::int64_t k = 1; k <= 20; ++k) {
    ProductRecord product;
    ASSERT_TRUE(get(rig.store, product_id(k, ProductKind::image), product).ok());
    EXPECT_EQ(product.state, ProductState::acknowledged);
  }
  EXPECT_GE(rig.on_ground.size(), 40U);
  EXPECT_EQ(rig.transfers(), 0);
}

}  // namespace
}  // namespace ilp
