#include "fsw/packets/cfdp_pdu.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "fsw/packets/cfdp_checksum.hpp"
#include "tests/support/golden_vectors.hpp"

namespace ilp::cfdp {
namespace {

std::string text(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

Bytes encoded(const Pdu& pdu) {
  Bytes out(65536 + 64);
  std::size_t size = 0;
  const Status status = encode(pdu, out, size);
  EXPECT_TRUE(status.ok()) << status_name(status.code) << " " << status.a;
  out.resize(size);
  return out;
}

PduFault fault_of(const Bytes& bytes) {
  Pdu pdu;
  const Status status = decode(bytes, pdu);
  if (status.ok()) return PduFault::none;
  EXPECT_TRUE(status.is(StatusCode::pdu_rejected));
  return static_cast<PduFault>(status.a);
}

/// Decodes, and expects the same octets back.
Pdu there_and_back(const Bytes& bytes) {
  Pdu pdu;
  const Status status = decode(bytes, pdu);
  EXPECT_TRUE(status.ok()) << words_of(static_cast<PduFault>(status.a));
  EXPECT_EQ(encoded(pdu), bytes);
  return pdu;
}

void expect_ids(const Pdu& pdu, std::uint64_t source, std::uint64_t sequence, std::uint64_t destination) {
  EXPECT_EQ(pdu.header.source, source);
  EXPECT_EQ(pdu.header.sequence, sequence);
  EXPECT_EQ(pdu.header.destination, destination);
}

class GoldenPdus : public testing::Test {
 protected:
  void SetUp() override {
    if (vectors_.empty()) GTEST_SKIP() << "no ../shared/data/tctm/cfdp.hex";
  }
  const Bytes& at(const char* name) { return vectors_.at(name); }

  std::map<std::string, Bytes> vectors_ = golden_vectors("cfdp.hex");
};

TEST_F(GoldenPdus, EveryOneComesBackAsTheSameOctets) {
  ASSERT_EQ(vectors_.size(), 29U);
  for (const auto& [name, bytes] : vectors_) {
    SCOPED_TRACE(name);
    // The last one is wrapped in a space packet.
    there_and_back(name == "packet_filedata" ? Bytes(bytes.begin() + 6, bytes.end()) : bytes);
  }
}

TEST_F(GoldenPdus, MetadataSaysWhatTheCommentSays) {
  for (const char* name : {"metadata", "metadata_modular", "metadata_class1_closure", "metadata_id1_seq4",
                           "metadata_id4_seq1", "metadata_large", "metadata_crc", "metadata_msg"}) {
    SCOPED_TRACE(name);
    const Pdu pdu = there_and_back(at(name));
    ASSERT_EQ(pdu.kind, PduKind::metadata);
    expect_ids(pdu, 1, 5, 2);
    EXPECT_EQ(pdu.header.unacknowledged, name == std::string("metadata_class1_closure"));
    EXPECT_EQ(pdu.metadata.closure_requested, name == std::string("metadata_class1_closure"));
    EXPECT_EQ(pdu.header.crc, name == std::string("metadata_crc"));
    EXPECT_EQ(pdu.metadata.checksum_type, name == std::string("metadata_modular") ? 0 : 3);
    EXPECT_EQ(pdu.header.large_file, name == std::string("metadata_large"));
    EXPECT_EQ(pdu.metadata.file_bytes, name == std::string("metadata_large") ? 5000000000U : 14U);
    EXPECT_EQ(text(pdu.metadata.source_name), "a.jp2");
    EXPECT_EQ(text(pdu.metadata.destination_name), "a.jp2");
  }
  const Pdu message = there_and_back(at("metadata_msg"));
  std::span<const std::uint8_t> options = message.metadata.options;
  Tlv tlv;
  ASSERT_TRUE(next_tlv(options, tlv));
  EXPECT_EQ(tlv.type, 2);
  EXPECT_EQ(text(tlv.value), "camera");
  EXPECT_FALSE(next_tlv(options, tlv));
  const Pdu no_file = there_and_back(at("metadata_only"));
  EXPECT_EQ(no_file.metadata.checksum_type, 15);
  EXPECT_TRUE(no_file.metadata.source_name.empty() && no_file.metadata.destination_name.empty());
  EXPECT_EQ(there_and_back(at("metadata_id1_seq4")).header.id_length, 1);
  EXPECT_EQ(there_and_back(at("metadata_id4_seq1")).header.sequence_length, 1);
}

TEST_F(GoldenPdus, FileDataSaysWhatTheCommentSays) {
  const std::map<const char*, std::uint64_t> offsets{
      {"filedata", 0}, {"filedata_off", 5}, {"filedata_crc", 0}, {"filedata_large", 4294967296}};
  for (const auto& [name, offset] : offsets) {
    SCOPED_TRACE(name);
    const Pdu pdu = there_and_back(at(name));
    ASSERT_EQ(pdu.kind, PduKind::file_data);
    EXPECT_EQ(pdu.file_data.offset, offset);
    EXPECT_EQ(text(pdu.file_data.bytes), std::string("Hello, ground.").substr(offset == 5 ? 5 : 0));
  }
}

TEST_F(GoldenPdus, EofFinishedAndTheirAcknowledgementsSayWhatTheCommentsSay) {
  Pdu pdu = there_and_back(at("eof"));
  EXPECT_EQ(pdu.kind, PduKind::eof);
  EXPECT_EQ(pdu.eof.checksum, 0xAA38BBF2U);
  EXPECT_EQ(pdu.eof.file_bytes, 14U);
  EXPECT_EQ(there_and_back(at("eof_modular")).eof.checksum, 0x8E2F0241U);
  EXPECT_EQ(there_and_back(at("eof_large")).eof.file_bytes, 5000000000U);
  pdu = there_and_back(at("eof_cancel"));
  EXPECT_EQ(pdu.eof.condition, Condition::cancel_request_received);
  EXPECT_EQ(pdu.eof.file_bytes, 5U);
  std::array<std::uint8_t, 10> location{};
  ASSERT_EQ(write_fault_location(1, 2, location), pdu.eof.options.size());
  EXPECT_TRUE(std::equal(pdu.eof.options.begin(), pdu.eof.options.end(), location.begin()));

  pdu = there_and_back(at("ack_eof"));
  EXPECT_EQ(pdu.kind, PduKind::ack);
  EXPECT_TRUE(pdu.header.toward_sender);
  EXPECT_FALSE(pdu.ack.of_finished);
  EXPECT_EQ(pdu.ack.status, TransactionStatus::active);
  EXPECT_EQ(there_and_back(at("ack_eof_term")).ack.status, TransactionStatus::terminated);
  pdu = there_and_back(at("ack_finished"));
  EXPECT_TRUE(pdu.ack.of_finished);
  EXPECT_FALSE(pdu.header.toward_sender);

  pdu = there_and_back(at("finished"));
  EXPECT_EQ(pdu.kind, PduKind::finished);
  EXPECT_EQ(pdu.finished.condition, Condition::no_error);
  EXPECT_FALSE(pdu.finished.incomplete);
  EXPECT_EQ(pdu.finished.file_status, FileStatus::retained);
  pdu = there_and_back(at("finished_incomplete"));
  EXPECT_EQ(pdu.finished.condition, Condition::nak_limit_reached);
  EXPECT_TRUE(pdu.finished.incomplete);
  EXPECT_EQ(pdu.finished.file_status, FileStatus::discarded);
}

TEST_F(GoldenPdus, NakPromptAndKeepAliveSayWhatTheCommentsSay) {
  Pdu pdu = there_and_back(at("nak_meta_two"));
  ASSERT_EQ(pdu.kind, PduKind::nak);
  EXPECT_EQ(pdu.nak.scope.end, 14U);
  ASSERT_EQ(gap_count(pdu.header, pdu.nak), 3U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 0).end, 0U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 1).end, 5U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 2).begin, 10U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 3).end, 0U);
  pdu = there_and_back(at("nak_one"));
  ASSERT_EQ(gap_count(pdu.header, pdu.nak), 1U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 0).begin, 5U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 0).end, 10U);
  pdu = there_and_back(at("nak_large"));
  ASSERT_EQ(gap_count(pdu.header, pdu.nak), 1U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 0).begin, 4294967296U);
  EXPECT_EQ(gap_at(pdu.header, pdu.nak, 0).end, 4294967552U);
  EXPECT_FALSE(there_and_back(at("prompt_nak")).prompt.keep_alive);
  EXPECT_TRUE(there_and_back(at("prompt_keepalive")).prompt.keep_alive);
  EXPECT_EQ(there_and_back(at("keepalive")).keep_alive.progress_bytes, 1000U);
}

TEST_F(GoldenPdus, EveryPrefixAndEveryLongerOneIsRejected) {
  for (const auto& [name, bytes] : vectors_) {
    if (name == "packet_filedata") continue;
    SCOPED_TRACE(name);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_NE(fault_of(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))), PduFault::none);
    }
    Bytes longer = bytes;
    longer.push_back(0);
    EXPECT_EQ(fault_of(longer), PduFault::length);
  }
}

TEST_F(GoldenPdus, AnyBitHitUnderACrcIsRejected) {
  for (const char* name : {"metadata_crc", "filedata_crc"}) {
    for (std::size_t bit = 0; bit < 8 * at(name).size(); ++bit) {
      // Without its flag a CRC is no CRC.
      if (bit == 6) continue;
      Bytes hit = at(name);
      hit[bit / 8] = static_cast<std::uint8_t>(hit[bit / 8] ^ (0x80U >> (bit % 8)));
      EXPECT_NE(fault_of(hit), PduFault::none) << name << " bit " << bit;
    }
  }
}

TEST_F(GoldenPdus, TheRecordedSessionComesBackAsTheSameOctets) {
  const std::vector<PduKind> kinds{PduKind::metadata, PduKind::file_data, PduKind::file_data, PduKind::file_data,
                                   PduKind::eof,      PduKind::ack,       PduKind::nak,       PduKind::file_data,
                                   PduKind::finished, PduKind::ack};
  std::ifstream in(golden_folder() / "cfdp_session.txt");
  std::size_t count = 0;
  Bytes file(150);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    SCOPED_TRACE(line);
    const Bytes bytes = from_hex(line.substr(line.rfind(' ') + 1));
    const Pdu pdu = there_and_back(bytes);
    expect_ids(pdu, 257, 0, 258);
    ASSERT_LT(count, kinds.size());
    EXPECT_EQ(pdu.kind, kinds[count++]);
    EXPECT_EQ(pdu.header.toward_sender, line.find("R>S") != std::string::npos);
    if (pdu.kind == PduKind::file_data) {
      std::copy(pdu.file_data.bytes.begin(), pdu.file_data.bytes.end(),
                file.begin() + static_cast<std::ptrdiff_t>(pdu.file_data.offset));
    }
    if (pdu.kind != PduKind::eof) continue;
    EXPECT_EQ(pdu.eof.checksum, 0x2D5DB522U);
    FileChecksum checksum(ChecksumType::modular);
    checksum.add(file);
    EXPECT_EQ(checksum.value(), pdu.eof.checksum) << "the lost segment counts too";
  }
  EXPECT_EQ(count, kinds.size());
}

TEST(CfdpPdu, IdsAndSequenceNumbersOfEveryLengthAreReadAndWritten) {
  for (std::uint8_t id = 1; id <= 8; ++id) {
    for (std::uint8_t sequence = 1; sequence <= 8; ++sequence) {
      Pdu pdu{.kind = PduKind::finished};
      pdu.header.toward_sender = true;
      pdu.header.id_length = id;
      pdu.header.sequence_length = sequence;
      pdu.header.source = 0xFFFFFFFFFFFFFFFFU >> (64U - 8U * id);
      pdu.header.sequence = 0x8182838485868788U >> (64U - 8U * sequence);
      const Bytes bytes = encoded(pdu);
      ASSERT_EQ(bytes.size(), 4U + 2U * id + sequence + 2U);
      const Pdu read = there_and_back(bytes);
      EXPECT_EQ(read.header.source, pdu.header.source);
      EXPECT_EQ(read.header.sequence, pdu.header.sequence);
    }
  }
  // A sequence number of 3 octets as the Java entity sends it: source 1, sequence 0x010203, destination 2.
  EXPECT_EQ(there_and_back(from_hex("200002 02 01 010203 02 0900")).header.sequence, 0x010203U);
}

TEST(CfdpPdu, MalformedOnesAreRejectedForTheirReason) {
  EXPECT_EQ(fault_of({}), PduFault::header_cut);
  EXPECT_EQ(fault_of(from_hex("200002 11 0001 0005 00")), PduFault::header_cut);
  EXPECT_EQ(fault_of(from_hex("000002 11 0001 0005 0002 0900")), PduFault::version);
  EXPECT_EQ(fault_of(from_hex("400002 11 0001 0005 0002 0900")), PduFault::version);
  EXPECT_EQ(fault_of(from_hex("200003 11 0001 0005 0002 0900")), PduFault::length);
  EXPECT_EQ(fault_of(from_hex("20ffff 11 0001 0005 0002 0900")), PduFault::length);
  EXPECT_EQ(fault_of(from_hex("200000 11 0001 0005 0002")), PduFault::directive_missing);
  EXPECT_EQ(fault_of(from_hex("220001 11 0001 0005 0002 09")), PduFault::length);
  EXPECT_EQ(fault_of(from_hex("220004 11 0001 0005 0002 0900 0000")), PduFault::crc);
  EXPECT_EQ(fault_of(from_hex("200002 11 0001 0005 0002 0a00")), PduFault::directive_unknown);
  EXPECT_EQ(fault_of(from_hex("200002 11 0001 0005 0002 ff00")), PduFault::directive_unknown);
  EXPECT_EQ(fault_of(from_hex("200001 11 0001 0005 0002 09")), PduFault::field_cut);
  EXPECT_EQ(fault_of(from_hex("200003 11 0001 0005 0002 090000")), PduFault::trailing_octets);
  EXPECT_EQ(fault_of(from_hex("280003 11 0001 0005 0002 067001")), PduFault::acknowledges_nothing);
  EXPECT_EQ(fault_of(from_hex("280010 11 0001 0005 0002 08 00000000 0000000e 00000005 000000")), PduFault::field_cut);
  // A name of 255 octets of which 3 are there; an option of 9 of which 2 are there.
  EXPECT_EQ(fault_of(from_hex("20000b 11 0001 0005 0002 07 03 0000000e ff 612e6a 70")), PduFault::field_cut);
  EXPECT_EQ(fault_of(from_hex("28000600 01 05 02 05 74 06 09 0002")), PduFault::tlv_cut);
  EXPECT_EQ(fault_of(from_hex("28000300 01 05 02 05 74 06")), PduFault::tlv_cut);
  EXPECT_EQ(fault_of(from_hex("30000300 01 05 02 000000")), PduFault::field_cut);
}

TEST(CfdpPdu, WhatDoesNotFitIsNotWritten) {
  Pdu pdu{.kind = PduKind::eof};
  pdu.eof.file_bytes = 0x1'0000'0000U;
  Bytes out(64);
  std::size_t size = 0;
  EXPECT_TRUE(encode(pdu, out, size).is(StatusCode::invalid_argument));
  pdu.header.large_file = true;
  EXPECT_TRUE(encode(pdu, out, size).ok());
  for (std::size_t capacity = 0; capacity < size; ++capacity) {
    std::size_t unused = 0;
    EXPECT_TRUE(encode(pdu, std::span(out).first(capacity), unused).is(StatusCode::capacity_exceeded)) << capacity;
  }
  pdu.header.source = 0x10000;
  EXPECT_TRUE(encode(pdu, out, size).is(StatusCode::invalid_argument));
  pdu.header.source = 1;
  pdu.header.id_length = 9;
  EXPECT_TRUE(encode(pdu, out, size).is(StatusCode::invalid_argument));
  Pdu name;
  const Bytes long_name(256, 'n');
  name.metadata.source_name = long_name;
  Bytes large(70000);
  EXPECT_TRUE(encode(name, large, size).is(StatusCode::invalid_argument));
  Pdu data{.kind = PduKind::file_data};
  const Bytes bytes(65532);
  data.file_data.bytes = bytes;
  EXPECT_TRUE(encode(data, large, size).is(StatusCode::capacity_exceeded));
  data.file_data.bytes = std::span(bytes).first(65531);
  EXPECT_TRUE(encode(data, large, size).ok());
  there_and_back(Bytes(large.begin(), large.begin() + static_cast<std::ptrdiff_t>(size)));
}

TEST(CfdpPdu, AnyBytesGiveAPduThatIsWrittenAgainOrAReason) {
  std::mt19937 random(7);
  Bytes out(65536 + 64);
  int decoded = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    Bytes bytes(random() % 48);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    // Most would fail at version and length alone.
    if (bytes.size() >= 4) {
      bytes[0] = static_cast<std::uint8_t>(0x20U | (bytes[0] & 0x1DU));
      bytes[3] = static_cast<std::uint8_t>(bytes[3] & 0x99U);
      const std::size_t head = 4 + 2 * (((bytes[3] >> 4U) & 7U) + 1U) + (bytes[3] & 7U) + 1;
      bytes[1] = 0;
      bytes[2] = static_cast<std::uint8_t>(bytes.size() - head);
      if (bytes.size() > head) bytes[head] = static_cast<std::uint8_t>(4 + random() % 10);
    }
    Pdu pdu;
    if (!decode(bytes, pdu).ok()) continue;
    ++decoded;
    std::size_t size = 0;
    ASSERT_TRUE(encode(pdu, out, size).ok());
    // Spare bits aside the octets are the same: a second turn changes nothing.
    Pdu again;
    ASSERT_TRUE(decode(std::span(out).first(size), again).ok());
    EXPECT_EQ(again.kind, pdu.kind);
    EXPECT_EQ(size, bytes.size());
    EXPECT_EQ(encoded(again), Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  EXPECT_GT(decoded, 10000);
}

TEST(CfdpChecksum, HasTheValuesOfIndependentImplementations) {
  const std::string hello = "Hello, ground.";
  const std::string digits = "123456789";
  const auto checksum = [](ChecksumType type, const std::string& content, std::size_t segment) {
    FileChecksum sum(type);
    const Bytes bytes(content.begin(), content.end());
    for (std::size_t at = 0; at < bytes.size(); at += segment) {
      sum.add(std::span(bytes).subspan(at, std::min(segment, bytes.size() - at)));
    }
    return sum.value();
  };
  for (std::size_t segment = 1; segment < 15; ++segment) {
    EXPECT_EQ(checksum(ChecksumType::modular, hello, segment), 0x8E2F0241U);
    EXPECT_EQ(checksum(ChecksumType::crc32, hello, segment), 0xAA38BBF2U);
    EXPECT_EQ(checksum(ChecksumType::crc32, "Hello", segment), 0xF7D18982U);
    EXPECT_EQ(checksum(ChecksumType::crc32c, digits, segment), 0xE3069283U);
    EXPECT_EQ(checksum(ChecksumType::null, digits, segment), 0U);
  }
  EXPECT_TRUE(is_supported(0) && is_supported(2) && is_supported(3) && is_supported(15));
  EXPECT_FALSE(is_supported(1) || is_supported(4) || is_supported(14));
}

}  // namespace
}  // namespace ilp::cfdp
