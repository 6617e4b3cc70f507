// The ground's receiver against senders that lie: what it takes of memory, what it forgets, what it never mixes up.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fsw/base/crc.hpp"
#include "sim/ground/cfdp/cfdp_receiver.hpp"
#include "tests/unit/ground/cfdp/largest_request.hpp"

namespace ilp::ground_cfdp {
namespace {

using Bytes = std::vector<std::uint8_t>;
using cfdp::Pdu;
using cfdp::PduKind;

Bytes contents(std::size_t size, std::uint8_t seed) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(seed + i * 7 + i / 251);
  return bytes;
}

class GroundReceiver : public testing::Test {
 protected:
  void begin(CfdpReceiverSettings settings) {
    receiver = std::make_unique<CfdpReceiver>(
        settings, [this](const Bytes& pdu) { answers.push_back(pdu); },
        [this](const std::string& name, const Bytes& file) {
          files[name] = file;
          return keeps;
        });
  }
  GroundReceiver() { begin({}); }

  void receive(const Pdu& pdu) {
    Bytes bytes(66'000);
    std::size_t size = 0;
    ASSERT_TRUE(cfdp::encode(pdu, bytes, size).ok());
    receiver->receive(std::span<const std::uint8_t>(bytes).first(size), now += 0.001);
  }
  static Pdu pdu_of(std::uint64_t sequence, PduKind kind) {
    Pdu pdu;
    pdu.header.large_file = true;
    pdu.header.id_length = pdu.header.sequence_length = 8;
    pdu.header.source = 1;
    pdu.header.sequence = sequence;
    pdu.header.destination = 2;
    pdu.kind = kind;
    return pdu;
  }
  void metadata(std::uint64_t sequence, const std::string& name, std::uint64_t file_bytes,
                std::uint8_t checksum_type = 3) {
    Pdu pdu = pdu_of(sequence, PduKind::metadata);
    pdu.metadata.checksum_type = checksum_type;
    pdu.metadata.file_bytes = file_bytes;
    const auto* octets = reinterpret_cast<const std::uint8_t*>(name.data());
    pdu.metadata.source_name = pdu.metadata.destination_name = {octets, name.size()};
    receive(pdu);
  }
  void data(std::uint64_t sequence, std::uint64_t offset, std::span<const std::uint8_t> bytes) {
    Pdu pdu = pdu_of(sequence, PduKind::file_data);
    pdu.file_data.offset = offset;
    pdu.file_data.bytes = bytes;
    receive(pdu);
  }
  void eof(std::uint64_t sequence, const Bytes& file) {
    Pdu pdu = pdu_of(sequence, PduKind::eof);
    pdu.eof.checksum = crc32(file);
    pdu.eof.file_bytes = file.size();
    receive(pdu);
  }
  void acknowledge(std::uint64_t sequence) {
    Pdu pdu = pdu_of(sequence, PduKind::ack);
    pdu.ack = {true, cfdp::Condition::no_error, cfdp::TransactionStatus::active};
    receive(pdu);
  }
  void whole(std::uint64_t sequence, const std::string& name, const Bytes& file) {
    metadata(sequence, name, file.size());
    data(sequence, 0, file);
    eof(sequence, file);
  }
  /// What was answered about a transaction since the last call.
  std::vector<Pdu> take_answers(std::uint64_t sequence) {
    std::vector<Pdu> list;
    for (const Bytes& bytes : answers) {
      Pdu pdu;
      EXPECT_TRUE(cfdp::decode(bytes, pdu).ok());
      if (pdu.header.sequence == sequence) list.push_back(pdu);
    }
    received = std::exchange(answers, {});
    return list;
  }
  /// The last Finished among them says that the file is kept.
  bool retained(std::uint64_t sequence) {
    bool yes = false;
    for (const Pdu& pdu : take_answers(sequence)) {
      if (pdu.kind == PduKind::finished) yes = pdu.finished.file_status == cfdp::FileStatus::retained;
    }
    return yes;
  }
  std::vector<cfdp::Gap> gaps_asked_for(std::uint64_t sequence) {
    std::vector<cfdp::Gap> gaps;
    for (const Pdu& pdu : take_answers(sequence)) {
      if (pdu.kind != PduKind::nak) continue;
      for (std::size_t i = 0; i < cfdp::gap_count(pdu.header, pdu.nak); ++i) {
        gaps.push_back(cfdp::gap_at(pdu.header, pdu.nak, i));
      }
    }
    return gaps;
  }

  std::unique_ptr<CfdpReceiver> receiver;
  std::vector<Bytes> answers, received;  // spans of the PDUs point into `received`
  std::map<std::string, Bytes> files;
  bool keeps = true;
  double now = 0;
};

TEST_F(GroundReceiver, DataAtTheEndOfAllNumbersIsWrittenNowhere) {
  const Bytes bytes(100, 0x55);
  metadata(1, "product-1", 1000);
  for (const std::uint64_t offset :
       {~std::uint64_t{0}, ~std::uint64_t{0} - 50, ~std::uint64_t{0} - 99, std::uint64_t{1} << 63U}) {
    data(1, offset, bytes);
  }
  const Bytes file = contents(1000, 1);
  data(1, 0, file);
  eof(1, file);
  EXPECT_EQ(files["product-1"], file);
  EXPECT_TRUE(retained(1));
}

TEST_F(GroundReceiver, MemoryFollowsWhatCameAndNotWhereItBelongs) {
  metadata(1, "product-1", 0);
  const Bytes bytes(100, 0x55);
  test::largest_request = 0;
  for (const std::uint64_t offset : {std::uint64_t{1} << 28U, (std::uint64_t{1} << 30U) - 200}) data(1, offset, bytes);
  data(1, (std::uint64_t{1} << 28U) - 100, bytes);
  EXPECT_LT(test::largest_request, 100'000U);
}

TEST_F(GroundReceiver, AFloodOfTransactionsDoesNotCostTheOneThatIsHeard) {
  const Bytes file = contents(40'000, 3);
  metadata(7, "product-1", file.size());
  std::uint64_t forged = 1000;
  for (std::size_t at = 0; at < file.size(); at += 1000) {
    for (int i = 0; i < 200; ++i) data(++forged, 0, Bytes(10));
    data(7, at, std::span(file).subspan(at, 1000));
    ASSERT_LE(receiver->open(), CfdpReceiverSettings{}.max_open);
  }
  eof(7, file);
  EXPECT_EQ(files["product-1"], file);
  EXPECT_GT(receiver->counts().forgotten, 7000U);
}

TEST_F(GroundReceiver, WhatIsHeldInAllIsBoundedAndTheOneSilentForLongestGivesWay) {
  CfdpReceiverSettings settings{.max_held_bytes = 100'000};
  begin(settings);
  const Bytes file = contents(30'000, 4);
  for (std::uint64_t sequence = 1; sequence <= 50; ++sequence) {
    metadata(sequence, "file-" + std::to_string(sequence), file.size());
    for (std::size_t at = 0; at < 29'000; at += 1000) data(sequence, at, std::span(file).subspan(at, 1000));
    ASSERT_LE(receiver->held_bytes(), settings.max_held_bytes);
  }
  EXPECT_EQ(receiver->open(), 2U);
  EXPECT_EQ(receiver->counts().forgotten, 48U);
  // A transaction that gave way is asked for the whole file, and is completed later.
  take_answers(1);
  eof(1, file);
  EXPECT_EQ(gaps_asked_for(1).size(), 2U) << "metadata and file";
  metadata(1, "file-1", file.size());
  for (std::size_t at = 0; at < file.size(); at += 1000) data(1, at, std::span(file).subspan(at, 1000));
  EXPECT_EQ(files["file-1"], file);
}

TEST_F(GroundReceiver, ANumberThatComesAgainIsANewFile) {
  const Bytes old = contents(5000, 1), other = contents(6000, 2), same_size = contents(6000, 3);
  whole(1, "product-1", old);
  EXPECT_TRUE(retained(1));
  // Still open: its Finished is not acknowledged.
  metadata(1, "product-2", other.size());
  eof(1, other);
  EXPECT_FALSE(retained(1)) << "nothing of it has come";
  data(1, 0, other);
  EXPECT_TRUE(retained(1));
  EXPECT_EQ(files["product-2"], other);
  acknowledge(1);
  EXPECT_EQ(receiver->open(), 0U);
  // The transaction is closed. The metadata are lost; the EOF shows that the number is used again.
  data(1, 0, same_size);
  eof(1, same_size);
  EXPECT_FALSE(retained(1));
  whole(1, "product-3", same_size);
  EXPECT_TRUE(retained(1));
  EXPECT_EQ(files["product-3"], same_size);
  acknowledge(1);
  // Closed, and metadata come.
  metadata(1, "product-4", old.size());
  eof(1, old);
  EXPECT_FALSE(retained(1));
  data(1, 0, old);
  EXPECT_TRUE(retained(1));
  EXPECT_EQ(files["product-4"], old);
  EXPECT_EQ(receiver->counts().restarted, 3U);
}

TEST_F(GroundReceiver, HalfOfAnOldFileIsNoPartOfTheNewOneOfItsNumber) {
  const Bytes old = contents(6000, 1), other = contents(6000, 2);
  metadata(1, "product-1", old.size());
  data(1, 0, std::span(old).first(3000));
  metadata(1, "product-2", other.size());
  data(1, 3000, std::span(other).subspan(3000));
  eof(1, other);
  const std::vector<cfdp::Gap> gaps = gaps_asked_for(1);
  ASSERT_FALSE(gaps.empty());
  EXPECT_EQ(gaps.back().begin, 0U);
  EXPECT_EQ(gaps.back().end, 3000U);
  data(1, 0, std::span(other).first(3000));
  EXPECT_EQ(files["product-2"], other);
  EXPECT_EQ(files.count("product-1"), 0U);
}

TEST_F(GroundReceiver, WhoAsksAgainAfterTheEndHearsTheAnswerAgain) {
  CfdpReceiverSettings settings{.limit = 2};
  begin(settings);
  const Bytes file = contents(5000, 1);
  whole(1, "product-1", file);
  EXPECT_TRUE(retained(1));
  // Nobody acknowledges: the flight is out of contact for longer than the ground repeats.
  for (int i = 0; i < 10; ++i) receiver->tick(now += 10);
  EXPECT_EQ(receiver->open(), 0U);
  take_answers(1);
  eof(1, file);
  EXPECT_TRUE(retained(1)) << "without a Finished the flight would never know";
}

TEST_F(GroundReceiver, WhatIsClosedIsForgottenOldestFirst) {
  CfdpReceiverSettings settings{.max_closed = 10};
  begin(settings);
  const Bytes file = contents(500, 1);
  for (std::uint64_t sequence = 1; sequence <= 30; ++sequence) {
    whole(sequence, "file-" + std::to_string(sequence), file);
    acknowledge(sequence);
  }
  EXPECT_EQ(receiver->closed(), 10U);
  take_answers(0);
  eof(21, file);
  EXPECT_TRUE(retained(21));
  eof(20, file);
  EXPECT_FALSE(retained(20)) << "begun again, as if it had never been";
}

TEST_F(GroundReceiver, ManyGapsAreAskedForInPortions) {
  metadata(1, "product-1", 40'000);
  const Bytes file = contents(40'000, 1);
  for (std::size_t at = 0; at + 4 <= file.size(); at += 8) data(1, at, std::span(file).subspan(at, 4));
  take_answers(1);
  eof(1, file);
  EXPECT_EQ(gaps_asked_for(1).size(), CfdpReceiverSettings{}.gaps_at_once);
  receiver->tick(now += 10);
  EXPECT_EQ(gaps_asked_for(1).size(), CfdpReceiverSettings{}.gaps_at_once);
}

// The condition codes of CCSDS 727.0-B-5. Of the checksum types in SANA's registry (0, 1, 2, 3, 15), type 1, that of
// Proximity-1, is not implemented here.
TEST_F(GroundReceiver, AChecksumOfAnUnknownTypeIsNotCalledAWrongChecksum) {
  const Bytes file = contents(500, 1);
  for (std::uint8_t type = 0; type < 16; ++type) {
    SCOPED_TRACE(int{type});
    const bool known = type == 0 || type == 2 || type == 3 || type == 15;
    const std::uint64_t sequence = 100 + type;
    metadata(sequence, "file-" + std::to_string(type), file.size(), type);
    data(sequence, 0, file);
    eof(sequence, file);
    std::vector<cfdp::Condition> conditions;
    for (const Pdu& pdu : take_answers(sequence)) {
      if (pdu.kind == PduKind::finished) conditions.push_back(pdu.finished.condition);
    }
    ASSERT_FALSE(conditions.empty());
    // The checksum of the EOF is the CRC-32.
    const cfdp::Condition of_known =
        type == 3 || type == 15 ? cfdp::Condition::no_error : cfdp::Condition::file_checksum_failure;
    EXPECT_EQ(conditions.front(), known ? of_known : cfdp::Condition::unsupported_checksum_type);
    EXPECT_EQ(files.count("file-" + std::to_string(type)), of_known == cfdp::Condition::no_error ? 1U : 0U);
  }
}

TEST_F(GroundReceiver, AFileThatIsTooLargeIsRefusedAndNotWaitedForForEver) {
  metadata(1, "product-1", std::uint64_t{1} << 40U);
  Pdu end = pdu_of(1, PduKind::eof);
  end.eof.file_bytes = std::uint64_t{1} << 40U;
  receive(end);
  bool refused = false;
  for (const Pdu& pdu : take_answers(1)) {
    refused = refused || (pdu.kind == PduKind::finished && pdu.finished.condition == cfdp::Condition::file_size_error);
  }
  EXPECT_TRUE(refused);
}

}  // namespace
}  // namespace ilp::ground_cfdp
