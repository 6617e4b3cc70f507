#include "fsw/downlink/file_delivery.hpp"

#include <gtest/gtest.h>

#include <string>

#include "fsw/downlink/downlink.hpp"
#include "tests/support/delivery_rig.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/store_records.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::DeliveryRig;

class FileDeliveryTest : public testing::Test {
 protected:
  void wish(std::int64_t sequence, TransferWish what) {
    test::in_transaction(rig.store, [&] { ASSERT_TRUE(request_transfer(rig.store, sequence, what).ok()); });
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
  static cfdp::Pdu ack_of_eof(std::uint64_t sequence, cfdp::TransactionStatus status) {
    cfdp::Pdu pdu = finished(sequence);
    pdu.kind = cfdp::PduKind::ack;
    pdu.ack = {false, cfdp::Condition::no_error, status};
    return pdu;
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
  rig.ground = std::make_unique<ground_cfdp::CfdpReceiver>(
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

TEST_F(FileDeliveryTest, WhatIsNotSentYetIsCountedAsItGoes) {
  rig.mission.cfdp_open_transfers = 1;
  const auto unsent = [this] {
    std::int64_t bytes = -1;
    EXPECT_TRUE(rig.board->queue.unsent(bytes).ok());
    return bytes;
  };
  EXPECT_EQ(unsent(), 0);
  for (const char* name : {"product-1", "product-2"}) rig.offer(name, rig.noise(200000));
  rig.step();
  // A link of 12.5 kB in a minor frame.
  std::int64_t before = unsent();
  EXPECT_LE(before, 400000);
  EXPECT_GE(before, 360000);
  for (int i = 0; i < 10; ++i) {
    rig.step();
    EXPECT_NEAR(static_cast<double>(before - unsent()), 12500, 2000);
    before = unsent();
  }
  // The records say the same, as far as they go.
  rig.reboot();
  EXPECT_GE(unsent(), before);
  EXPECT_LE(unsent(), 400000);
  rig.step();
  wish(1, TransferWish::suspend);
  steps(6);
  EXPECT_LE(unsent(), 200000) << "a suspended transfer delays no other";
  rig.reboot();
  EXPECT_LE(unsent(), 200000);
  wish(1, TransferWish::resume);
  rig.run(400);
  EXPECT_EQ(unsent(), 0);
  // What is lost is sent again.
  rig.link->faults().loss = 1;
  rig.offer("product-3", rig.noise(20000));
  steps(4);
  EXPECT_EQ(unsent(), 0) << "all of it has been sent once";
  rig.link->faults().loss = 0;
  std::int64_t most = 0;
  rig.mission.link_bytes_per_s = 1000;
  for (int i = 0; i < 200; ++i) {
    rig.step();
    most = std::max(most, unsent());
  }
  EXPECT_GE(most, 15000);
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
  EXPECT_TRUE(request_transfer(rig.store, 77, TransferWish::cancel).is(StatusCode::not_found));
}

// Behind the store epochs that are counted, transaction numbers begin by the calendar, beyond 2^32.
TEST_F(FileDeliveryTest, ATransactionWithALongNumberIsNamedByItsLastOctets) {
  TransferRecord transfer{.id = 1, .state = TransferState::sending};
  for (const std::int64_t number : {std::int64_t{77}, (std::int64_t{1} << 32U) + 5, std::int64_t{6'500'000'000'000}}) {
    transfer.sequence = number;
    Transaction transaction(rig.store);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(put(rig.store, transfer).ok());
    EXPECT_TRUE(request_transfer(rig.store, number & 0xFFFFFFFF, TransferWish::cancel).ok()) << number;
    EXPECT_TRUE(request_transfer(rig.store, (number + 1) & 0xFFFFFFFF, TransferWish::cancel).is(StatusCode::not_found));
    EXPECT_EQ(record().wish, TransferWish::cancel);
  }
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
  send_to_board(ack_of_eof(1, cfdp::TransactionStatus::active));
  rig.step();
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

TEST_F(FileDeliveryTest, AnOldFinishedOrAClosedTransactionDeliversNoNewFile) {
  rig.ground_listens = false;
  rig.offer("product-1", rig.noise(2000));
  steps(5);
  // The ground holds an earlier file of this number, from a database that is no more.
  send_to_board(finished(1));
  steps(5);
  send_to_board(ack_of_eof(1, cfdp::TransactionStatus::terminated));
  send_to_board(finished(1));
  steps(5);
  EXPECT_EQ(rig.sent.count("product-1"), 1U) << "deleted on board, and the ground never got it";
  EXPECT_TRUE(rig.saw(StatusCode::transfer_spent));
  rig.mission.cfdp_rest_s = 1;
  rig.ground_listens = true;
  rig.run(1000);
  EXPECT_TRUE(rig.on_ground["product-1"] == rig.files["product-1"]);
}

TEST_F(FileDeliveryTest, AFileThatIsRefusedWaitsTwiceAsLongEachTime) {
  rig.mission.cfdp_rest_s = 5;
  rig.ground_keeps = false;
  rig.offer("product-1", rig.noise(1000));
  std::vector<int> began;
  std::int64_t sequence = 0;
  for (int i = 0; i < 60000 && began.size() < 10; ++i) {
    rig.step();
    if (record().sequence == sequence) continue;
    sequence = record().sequence;
    began.push_back(i);
  }
  ASSERT_EQ(began.size(), 10U);
  // In minor frames of 0.1 s: 5 s, 10 s, ... 320 s, and no longer. Each transaction takes some frames itself.
  for (std::size_t k = 1; k < began.size(); ++k) {
    const int pause = 50 << (k - 1 < 6 ? k - 1 : 6);
    EXPECT_GE(began[k] - began[k - 1], pause) << k;
    EXPECT_LE(began[k] - began[k - 1], pause + 10) << k;
  }
}

TEST_F(FileDeliveryTest, ADamagedTransferIsCancelledAndHoldsNobodyUp) {
  rig.mission.cfdp_open_transfers = 1;
  rig.offer("product-1", rig.noise(500000));
  steps(3);
  rig.offer("product-2", rig.noise(2000));
  rig.step();
  rig.failing.judge_by([](const test::FailingStore::Call& call) {
    const bool hit = call.kind == test::StoreCall::read_blob && call.id == 1;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  wish(1, TransferWish::cancel);
  steps(300);
  EXPECT_TRUE(rig.saw(StatusCode::transfer_cancelled));
  EXPECT_EQ(rig.confirmed.count("product-2"), 1U);
  EXPECT_EQ(rig.transfers(), 0);
}

TEST_F(FileDeliveryTest, AFileThatCannotBeReadWaitsAndIsGivenUpInTheEndWhileOthersGo) {
  rig.mission.cfdp_rest_s = 1;
  const struct {
    Status fault;
    int most_steps;
    bool of_record;
  } cases[] = {{{StatusCode::store_error, 10}, 6000, false},
               {{StatusCode::record_damaged, 1, 18}, 300, false},
               {{StatusCode::store_error, 10}, 6000, true},
               {{StatusCode::record_damaged, 1, 18}, 300, true}};
  std::int64_t hit = 0;
  for (const auto& c : cases) {
    SCOPED_TRACE(testing::Message() << status_name(c.fault.code) << (c.of_record ? " of the record" : " of the file"));
    rig.events.clear();
    rig.offer("product-bad", rig.noise(100000));
    rig.offer("product-good", rig.noise(30000));
    rig.step();
    hit = record().id;
    rig.failing.judge_by([&](const test::FailingStore::Call& call) {
      const auto kind = c.of_record ? test::StoreCall::get : test::StoreCall::read_blob;
      return call.kind == kind && call.type == RecordType::transfer && call.id == hit ? c.fault : Status{};
    });
    steps(100);
    EXPECT_EQ(rig.sent.count("product-good"), 0U) << "held up";
    EXPECT_EQ(rig.sent.count("product-bad"), 1U);
    std::int64_t unsent = -1;
    EXPECT_TRUE(rig.board->queue.unsent(unsent).ok());
    EXPECT_EQ(unsent, 0) << "the next file waits for it";
    for (int i = 0; i < c.most_steps && rig.transfers() > 0; ++i) rig.step();
    EXPECT_EQ(rig.transfers(), 0) << "for ever";
    EXPECT_TRUE(rig.saw(StatusCode::transfer_given_up));
    EXPECT_EQ(rig.ground->open(), c.of_record ? rig.ground->open() : 0U) << "the ground knows that nothing will come";
    rig.failing.recover();
    // Its confirmation is overdue: it comes again.
    rig.sent.clear();
    rig.offer("product-bad", rig.files["product-bad"]);
    rig.run(2000);
    rig.confirmed.clear();
  }
}

TEST_F(FileDeliveryTest, ADamagedRecordOfATransferStopsNeitherTheQueueNorWishes) {
  rig.ground_listens = false;
  for (const char* name : {"product-1", "product-2"}) rig.offer(name, rig.noise(1000));
  rig.step();
  test::FailingStore failing(rig.store);
  DeliveryQueue queue(failing, rig.clock, rig.mission, test::step_memory<DeliveryQueue>());
  Transaction transaction(failing);
  ASSERT_TRUE(transaction.begin().ok());
  failing.damage(RecordType::transfer, 1);
  ASSERT_TRUE(queue.begin_file("product-3").ok());
  ASSERT_TRUE(queue.write(Bytes(10)).ok());
  EXPECT_TRUE(queue.end_file().ok());
  failing.damage(RecordType::transfer, 2);
  EXPECT_TRUE(request_transfer(failing, 0, TransferWish::suspend).ok());
  ASSERT_TRUE(transaction.commit().ok());
  EXPECT_EQ(rig.transfers(), 2) << "the damaged one is gone";
}

TEST_F(FileDeliveryTest, AStoreThatFailsForAMinuteLosesNothingAndNothingGoesTwice) {
  for (int i = 0; i < 5; ++i) rig.offer("product-" + std::to_string(i), rig.noise(100000));
  steps(5);
  rig.failing.judge_by([](const test::FailingStore::Call&) { return Status{StatusCode::store_error, 10}; });
  steps(600);
  rig.failing.recover();
  rig.run(2000);
  EXPECT_EQ(rig.confirmed.size(), 5U);
  EXPECT_EQ(rig.ground->counts().repeated_bytes, 0U);
  EXPECT_FALSE(rig.saw(StatusCode::transfer_given_up));
  // Every second call fails for a while.
  for (int i = 5; i < 10; ++i) rig.offer("product-" + std::to_string(i), rig.noise(100000));
  rig.failing.judge_by([this](const test::FailingStore::Call&) {
    return rig.random() % 2 == 0 ? Status{StatusCode::store_error, 10} : Status{};
  });
  steps(600);
  rig.failing.recover();
  rig.run(5000);
  EXPECT_EQ(rig.confirmed.size(), 10U);
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
  EXPECT_GT(rig.board->figures.counts.rejected, 1000U);
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
  for (const EnumValue& checksum : cfdp::ChecksumType_values) {
    for (const std::uint8_t octets : {std::uint8_t{1}, std::uint8_t{4}, std::uint8_t{8}}) {
      rig.mission.cfdp_checksum = static_cast<cfdp::ChecksumType>(checksum.number);
      rig.mission.cfdp_pdu_crc = 1;
      rig.mission.cfdp_sequence_octets = octets;
      rig.reboot();
      rig.offer(std::string("product-") + checksum.name + std::to_string(octets), rig.noise(10001));
      rig.run(100);
    }
  }
  EXPECT_EQ(rig.confirmed.size(), 12U);
}

// A ground that knows 1 to 255 from before would take a number that comes again for what it has already.
TEST_F(FileDeliveryTest, NumbersThatAreUsedUpGetLongerAndNeverComeAgain) {
  rig.mission.cfdp_sequence_octets = 1;
  rig.reboot();
  std::map<std::int64_t, std::string> used;
  for (int i = 0; i < 300; ++i) {
    rig.offer("product-" + std::to_string(i), rig.noise(20));
    for (int step = 0; step < 200 && !rig.done(); ++step) {
      rig.step();
      for (const TransferRecord& record : test::records_of<TransferRecord>(rig.store)) {
        if (record.sequence == 0) continue;
        const auto [place, fresh] = used.emplace(record.sequence, record.name);
        ASSERT_EQ(place->second, record.name) << "transaction " << record.sequence << " came again";
      }
    }
    ASSERT_TRUE(rig.done()) << "file " << i;
    if (i % 50 == 49) rig.reboot();
  }
  EXPECT_EQ(used.size(), 300U);
  EXPECT_GE(used.rbegin()->first, 300);
}

TEST_F(FileDeliveryTest, WithoutALinkItRests) {
  PacketRouter none(nullptr, nullptr, rig.clock, rig.mission);
  DeliveryFigures figures;
  FileDelivery delivery(rig.store, none, rig.clock, rig.mission, figures);
  ASSERT_TRUE(delivery.restore().ok());
  rig.ground_listens = false;
  EXPECT_TRUE(delivery.step().status.ok());
}

TEST_F(FileDeliveryTest, TheRealDownlinkQueuesItsFilesAndBelievesOnlyWhatArrived) {
  auto downlink =
      std::make_unique<Downlink>(rig.store, rig.board->queue, rig.clock, rig.mission, test::step_memory<Downlink>());
  ASSERT_TRUE(downlink->restore().ok());
  rig.mission.cfdp_queue_kib = 40;
  Transaction transaction(rig.store);
  ASSERT_TRUE(transaction.begin().ok());
  for (std::int64_t k = 1; k <= 20; ++k) {
    KeyframeRecord keyframe{.id = k, .frame_id = k, .strip_id = 1};
    ASSERT_TRUE(put(rig.store, keyframe).ok());
    ProductRecord product{.id = product_id(k, ProductKind::image), .keyframe_id = k, .priority = 0.5};
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
      const StepResult result = downlink->step();
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
