#include "fsw/packets/cfdp_receiver.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace ilp::cfdp {
namespace {

using Bytes = std::vector<std::uint8_t>;

class CfdpReceiverTest : public testing::Test {
 protected:
  CfdpReceiverTest() {
    header.source = 2;
    header.sequence = 77;
    header.sequence_length = 3;
    header.destination = 1;
    for (std::size_t i = 0; i < file.size(); ++i) file[i] = static_cast<std::uint8_t>(i * 37 + i / 251);
    receiver->begin(header, settings, now);
  }

  Pdu pdu(PduKind kind) const {
    Pdu made{.header = header, .kind = kind};
    return made;
  }
  void receive_metadata(std::uint64_t size = 1000, std::uint8_t checksum_type = 3) {
    Pdu made = pdu(PduKind::metadata);
    made.metadata.file_bytes = size;
    made.metadata.checksum_type = checksum_type;
    made.metadata.destination_name = {reinterpret_cast<const std::uint8_t*>("a.ini"), 5};
    receiver->receive(made, now);
  }
  void receive_data(std::uint64_t begin, std::uint64_t end) {
    Pdu made = pdu(PduKind::file_data);
    made.file_data.offset = begin;
    made.file_data.bytes = std::span<const std::uint8_t>(file).subspan(begin % file.size(), end - begin);
    receiver->receive(made, now);
  }
  void receive_eof(Condition condition = Condition::no_error, std::uint64_t size = 1000) {
    Pdu made = pdu(PduKind::eof);
    FileChecksum checksum(ChecksumType::crc32);
    checksum.add(std::span<const std::uint8_t>(file).first(1000));
    made.eof = {condition, checksum.value(), size, {}};
    receiver->receive(made, now);
  }
  void receive_ack() {
    Pdu made = pdu(PduKind::ack);
    made.ack.of_finished = true;
    receiver->receive(made, now);
  }
  /// What goes now, each PDU encoded and decoded again.
  std::vector<Pdu> go() {
    std::vector<Pdu> pdus;
    PduKind kind = PduKind::count;
    for (int i = 0; i < 100 && receiver->next(kind); ++i) {
      Pdu made;
      receiver->build(kind, made);
      sent.emplace_back(2048);
      std::size_t size = 0;
      EXPECT_TRUE(encode(made, sent.back(), size).ok());
      Pdu read;
      EXPECT_TRUE(decode(std::span<const std::uint8_t>(sent.back()).first(size), read).ok());
      pdus.push_back(read);
      receiver->sent(kind, now);
    }
    return pdus;
  }
  static std::string gaps_of(const Pdu& nak) {
    std::string text;
    for (std::size_t i = 0; i < gap_count(nak.header, nak.nak); ++i) {
      const Gap gap = gap_at(nak.header, nak.nak, i);
      text += std::to_string(gap.begin) + "-" + std::to_string(gap.end) + " ";
    }
    return text;
  }
  std::vector<Pdu> wait(int seconds) {
    std::vector<Pdu> pdus;
    for (int i = 0; i < seconds; ++i) {
      now += ns_per_s;
      receiver->tick(now);
      for (const Pdu& made : go()) pdus.push_back(made);
    }
    return pdus;
  }

  Header header;
  ReceiverSettings settings;
  std::unique_ptr<Receiver> receiver = std::make_unique<Receiver>();
  TimeNs now = 0;
  Bytes file = Bytes(2000);
  std::vector<Bytes> sent = [] {
    std::vector<Bytes> keep;
    keep.reserve(4096);
    return keep;
  }();
};

TEST_F(CfdpReceiverTest, TakesAFileInOrderAndAnswersWithTheLengthsThatItReceived) {
  receive_metadata();
  receive_data(0, 600);
  receive_data(600, 1000);
  EXPECT_TRUE(go().empty());
  receive_eof();
  auto pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(pdus[0].kind, PduKind::ack);
  EXPECT_EQ(pdus[0].ack.status, TransactionStatus::active);
  EXPECT_EQ(pdus[0].header.sequence_length, 3);
  EXPECT_EQ(pdus[0].header.sequence, 77U);
  EXPECT_TRUE(pdus[0].header.toward_sender);
  ASSERT_EQ(receiver->phase(), ReceivePhase::whole);
  EXPECT_STREQ(receiver->name(), "a.ini");
  EXPECT_TRUE(std::equal(file.begin(), file.begin() + 1000, receiver->file().begin(), receiver->file().end()));
  receiver->conclude(Condition::no_error, FileStatus::retained, now);
  pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(pdus[0].kind, PduKind::finished);
  EXPECT_FALSE(pdus[0].finished.incomplete);
  EXPECT_EQ(pdus[0].finished.file_status, FileStatus::retained);
  // Finished goes until it is acknowledged, and no longer.
  EXPECT_EQ(wait(25).size(), 2U);
  receive_eof();
  EXPECT_EQ(go().size(), 1U) << "every EOF is acknowledged";
  receive_ack();
  EXPECT_EQ(receiver->phase(), ReceivePhase::closed);
  EXPECT_TRUE(wait(100).empty());
}

TEST_F(CfdpReceiverTest, AsksForAGapAtOnceAndForAllOfThemBehindTheEof) {
  receive_metadata();
  receive_data(0, 100);
  receive_data(200, 300);
  auto pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(gaps_of(pdus[0]), "100-200 ");
  receive_data(400, 500);
  pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(gaps_of(pdus[0]), "300-400 ");
  receive_data(320, 340);
  receive_eof();
  pdus = go();
  ASSERT_EQ(pdus.size(), 2U);
  EXPECT_EQ(gaps_of(pdus[1]), "100-200 300-320 340-400 500-1000 ");
  EXPECT_EQ(pdus[1].nak.scope.end, 1000U);
  receive_data(100, 400);
  receive_data(500, 1000);
  EXPECT_EQ(receiver->phase(), ReceivePhase::whole);
}

TEST_F(CfdpReceiverTest, KeepsDataThatCameBeforeTheMetadataAndAsksForThese) {
  receive_data(500, 1000);
  auto pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(gaps_of(pdus[0]), "0-0 0-500 ");
  receive_data(0, 500);
  EXPECT_TRUE(go().empty()) << "asked for once";
  receive_eof();
  pdus = go();
  ASSERT_EQ(pdus.size(), 2U);
  EXPECT_EQ(gaps_of(pdus[1]), "0-0 ");
  receive_metadata();
  EXPECT_EQ(receiver->phase(), ReceivePhase::whole);
}

TEST_F(CfdpReceiverTest, ALostNakGoesAgainUntilItsLimit) {
  receive_metadata();
  receive_eof();
  EXPECT_EQ(go().size(), 2U);
  auto pdus = wait(41);
  ASSERT_EQ(pdus.size(), 4U);
  for (const Pdu& nak : pdus) EXPECT_EQ(gaps_of(nak), "0-1000 ");
  pdus = wait(10);
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(pdus[0].kind, PduKind::finished);
  EXPECT_EQ(pdus[0].finished.condition, Condition::nak_limit_reached);
  EXPECT_TRUE(pdus[0].finished.incomplete);
  EXPECT_EQ(pdus[0].finished.file_status, FileStatus::discarded);
  EXPECT_FALSE(pdus[0].finished.options.empty()) << "fault location";
  EXPECT_EQ(wait(200).size(), 4U);
  EXPECT_EQ(receiver->phase(), ReceivePhase::closed) << "nobody acknowledges: it ends";
}

TEST_F(CfdpReceiverTest, AWrongChecksumIsNoFile) {
  receive_metadata();
  file[17] = static_cast<std::uint8_t>(file[17] ^ 1U);
  receive_data(0, 1000);
  file[17] = static_cast<std::uint8_t>(file[17] ^ 1U);
  receive_eof();
  EXPECT_EQ(receiver->phase(), ReceivePhase::finished);
  EXPECT_EQ(receiver->condition(), Condition::file_checksum_failure);
  EXPECT_EQ(receiver->file_status(), FileStatus::discarded);
}

TEST_F(CfdpReceiverTest, FilesThatDoNotFitAreRejected) {
  receive_metadata(limits::max_uplink_bytes + 1);
  EXPECT_EQ(receiver->condition(), Condition::filestore_rejection);
  receiver->begin(header, settings, now);
  receive_metadata(1000, 7);
  EXPECT_EQ(receiver->condition(), Condition::unsupported_checksum_type);
  receiver->begin(header, settings, now);
  receive_eof(Condition::no_error, std::uint64_t{1} << 40U);
  EXPECT_EQ(receiver->condition(), Condition::filestore_rejection);
  for (const std::uint64_t offset :
       {std::uint64_t{limits::max_uplink_bytes} - 1, std::uint64_t{0xFFFFFFFF}, std::uint64_t{0xFFFFFFFFFFFFFFFF}}) {
    receiver->begin(header, settings, now);
    Pdu made = pdu(PduKind::file_data);
    made.file_data.offset = offset;
    made.file_data.bytes = std::span<const std::uint8_t>(file).first(100);
    receiver->receive(made, now);
    EXPECT_EQ(receiver->condition(), Condition::file_size_error);
  }
  // Data beyond the size that the EOF has stated, and an EOF shorter than the data.
  receiver->begin(header, settings, now);
  receive_metadata();
  receive_eof();
  receive_data(900, 1001);
  EXPECT_EQ(receiver->condition(), Condition::file_size_error);
  receiver->begin(header, settings, now);
  receive_data(900, 1001);
  receive_eof();
  EXPECT_EQ(receiver->condition(), Condition::file_size_error);
}

TEST_F(CfdpReceiverTest, ACancelledTransferIsNoFile) {
  receive_metadata();
  receive_data(0, 1000);
  receive_eof(Condition::cancel_request_received, 500);
  EXPECT_EQ(receiver->condition(), Condition::cancel_request_received);
  const auto pdus = go();
  ASSERT_EQ(pdus.size(), 2U);
  EXPECT_EQ(pdus[0].ack.condition, Condition::cancel_request_received);
  EXPECT_TRUE(pdus[1].finished.incomplete);
}

TEST_F(CfdpReceiverTest, PromptsAreAnswered) {
  receive_metadata();
  receive_data(0, 300);
  Pdu prompt = pdu(PduKind::prompt);
  prompt.prompt.keep_alive = true;
  receiver->receive(prompt, now);
  auto pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(pdus[0].keep_alive.progress_bytes, 300U);
  receive_data(400, 500);
  go();
  prompt.prompt.keep_alive = false;
  receiver->receive(prompt, now);
  pdus = go();
  ASSERT_EQ(pdus.size(), 1U);
  EXPECT_EQ(gaps_of(pdus[0]), "300-400 ");
}

TEST_F(CfdpReceiverTest, ASilentSenderIsGivenUp) {
  receive_metadata();
  receive_data(0, 300);
  wait(299);
  EXPECT_EQ(receiver->phase(), ReceivePhase::data);
  wait(2);
  EXPECT_EQ(receiver->condition(), Condition::inactivity_detected);
}

TEST_F(CfdpReceiverTest, MoreGapsThanItHoldsAreFilledAllTheSame) {
  file.resize(40000);
  for (std::size_t i = 0; i < file.size(); ++i) file[i] = static_cast<std::uint8_t>(i * 37 + i / 251);
  receive_metadata(40000);
  // Every other piece of 50: 400 gaps.
  for (std::uint64_t at = 0; at < 40000; at += 100) receive_data(at, at + 50);
  receive_data(39950, 40000);
  Pdu eof = pdu(PduKind::eof);
  FileChecksum checksum(ChecksumType::crc32);
  checksum.add(file);
  eof.eof = {Condition::no_error, checksum.value(), 40000, {}};
  receiver->receive(eof, now);
  for (int round = 0; round < 20 && receiver->phase() == ReceivePhase::data; ++round) {
    for (const Pdu& nak : go()) {
      if (nak.kind != PduKind::nak) continue;
      for (std::size_t i = 0; i < gap_count(nak.header, nak.nak); ++i) {
        const Gap gap = gap_at(nak.header, nak.nak, i);
        receive_data(gap.begin, gap.end);
      }
    }
    wait(10);
  }
  ASSERT_EQ(receiver->phase(), ReceivePhase::whole);
  EXPECT_TRUE(std::equal(file.begin(), file.end(), receiver->file().begin(), receiver->file().end()));
}

TEST_F(CfdpReceiverTest, AnyOrderOfAnyPiecesGivesTheFileOrNone) {
  std::uint32_t random = 3;
  const auto next_random = [&](std::uint64_t below) {
    random = random * 1664525U + 1013904223U;
    return (random >> 8U) % below;
  };
  int whole = 0;
  for (int trial = 0; trial < 200; ++trial) {
    receiver->begin(header, settings, now);
    for (int i = 0; i < 400 && receiver->phase() == ReceivePhase::data; ++i) {
      // The first octet as often as others.
      const std::uint64_t place = next_random(1100);
      const std::uint64_t begin = place < 100 ? 0 : place - 100;
      const std::uint64_t end = begin + next_random(1001 - begin);
      if (i % 7 == 0) receive_metadata();
      if (i % 11 == 5) receive_eof();
      receive_data(begin, end);
      go();
    }
    if (receiver->phase() != ReceivePhase::whole) continue;
    ++whole;
    EXPECT_TRUE(std::equal(file.begin(), file.begin() + 1000, receiver->file().begin(), receiver->file().end()));
  }
  EXPECT_GT(whole, 150);
}

}  // namespace
}  // namespace ilp::cfdp
