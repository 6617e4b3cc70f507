// Files from the ground, through FileDelivery and the link.
#include "fsw/downlink/uplink.hpp"

#include <gtest/gtest.h>

#include <string>

#include "cfg/mission_text.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/downlink/uplink_fixture.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::DeliveryRig;
using test::UplinkTest;

Bytes text(const std::string& content) {
  return {content.begin(), content.end()};
}

TEST_F(UplinkTest, AParameterFileIsCheckedKeptAndTakesEffectWhenActivated) {
  const auto sent = put("/somewhere/mission.ini", text("; new values\n[overlap]\ntarget_overlap = 0.9 ; more\n"
                                                       "[downlink]\r\nlink_bytes_per_s: 2.5e4\r\n"));
  EXPECT_EQ(sent.state, ground_cfdp::CfdpSender::State::retained);
  const UplinkRecord record = newest();
  EXPECT_EQ(record.state, UplinkState::checked);
  EXPECT_STREQ(record.name, "mission.ini");
  EXPECT_EQ(record.source, 2);
  EXPECT_TRUE(rig.saw(StatusCode::uplink_received));
  MissionParameters mission;
  const MissionParameters before = mission;
  EXPECT_EQ(mission.target_overlap, before.target_overlap) << "nothing takes effect by itself";
  ASSERT_TRUE(activate(record.id, mission).ok());
  EXPECT_EQ(mission.target_overlap, 0.9);
  EXPECT_EQ(mission.link_bytes_per_s, 25000);
  EXPECT_EQ(newest().state, UplinkState::active);
  // The next one takes its place.
  put("next.ini", text("[overlap]\ntarget_overlap = 0.8\n"));
  ASSERT_TRUE(activate(record.id + 1, mission).ok());
  EXPECT_EQ(mission.target_overlap, 0.8);
  UplinkRecord first;
  ASSERT_TRUE(get(rig.store, record.id, first).ok());
  EXPECT_EQ(first.state, UplinkState::superseded);
  EXPECT_TRUE(activate(99, mission).is(StatusCode::not_found));
}

TEST_F(UplinkTest, AFileThatIsNotRightIsRejectedAndTheGroundHearsIt) {
  const struct {
    const char* name;
    const char* content;
    StatusCode fault;
    std::int64_t place;
  } cases[] = {
      {"mission.ini", "[overlap]\ntarget_overlap = 9\n", StatusCode::parameter_out_of_range, 2},
      {"mission.ini", "[overlap]\n\nno_such_thing = 1\n", StatusCode::not_found, 3},
      {"mission.ini", "[overlap\n", StatusCode::parse_error, 1},
      {"mission.ini", "[overlap]\ntarget_overlap\n", StatusCode::parse_error, 2},
      {"mission.ini", "[overlap]\ntarget_overlap = 0.9x\n", StatusCode::parameter_out_of_range, 2},
      {"mission.ini", "[overlap]\nmin_overlap = 0.95\n", StatusCode::parameters_contradict, 1},
      {"firmware.bin", "anything", StatusCode::unsupported_format, 0},
      {".ini", "[overlap]\n", StatusCode::unsupported_format, 0},
      {"a b.ini", "[overlap]\n", StatusCode::unsupported_format, 0},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.content);
    const auto sent = put(c.name, text(c.content));
    EXPECT_EQ(sent.state, ground_cfdp::CfdpSender::State::failed);
    EXPECT_EQ(sent.condition, cfdp::Condition::filestore_rejection);
    EXPECT_EQ(sent.file_status, cfdp::FileStatus::rejected_by_filestore);
    const UplinkRecord record = newest();
    EXPECT_EQ(record.state, UplinkState::rejected);
    EXPECT_EQ(record.fault, static_cast<std::uint16_t>(c.fault));
    EXPECT_EQ(record.fault_place, c.place);
    MissionParameters mission;
    EXPECT_TRUE(activate(record.id, mission).is(StatusCode::invalid_argument));
  }
  EXPECT_TRUE(rig.saw(StatusCode::uplink_rejected));
}

TEST_F(UplinkTest, ArrivesOverABadLinkInspiteOfRestarts) {
  rig.link->faults().loss = 0.2;
  rig.link->faults().duplication = 0.1;
  rig.link->faults().reordering = 0.2;
  rig.link->faults().delay_ns = 200 * ns_per_ms;
  std::string content = "[overlap]\ntarget_overlap = 0.9\n";
  for (int i = 0; i < 800; ++i) content += "; a line of no meaning, number " + std::to_string(i) + "\n";
  for (int trial = 0; trial < 10; ++trial) {
    const std::uint64_t sequence = sender.put("mission.ini", text(content), rig.now_s());
    for (int i = 0; i < 5000 && sender.transfer(sequence).state == ground_cfdp::CfdpSender::State::going; ++i) {
      step();
      if (rig.random() % 100 == 0) rig.reboot();
    }
    EXPECT_EQ(sender.transfer(sequence).state, ground_cfdp::CfdpSender::State::retained);
    const UplinkRecord record = newest();
    ASSERT_EQ(record.data.bytes, content.size());
    Bytes held(content.size());
    ASSERT_TRUE(read_blob<UplinkRecord>(rig.store, "data", record.id, 0, held).ok());
    EXPECT_TRUE(held == text(content));
    EXPECT_EQ(record.state, UplinkState::checked);
  }
  std::int64_t count = 0;
  ASSERT_TRUE(rig.store.count(record_info<UplinkRecord>(), count).ok());
  EXPECT_LE(count, static_cast<std::int64_t>(limits::max_uplink_records)) << "a transfer is one record";
  EXPECT_EQ(newest().id, 10) << "none was kept twice";
}

TEST_F(UplinkTest, AFileThatComesAgainBehindARestartIsKeptOnce) {
  put("a.ini", text("[overlap]\n"));
  for (int i = 0; i < 10; ++i) step();
  rig.reboot();
  // The same transaction from its beginning.
  sender = ground_cfdp::CfdpSender{{}, [this](const Bytes& pdu) { static_cast<void>(rig.link->ground().send(pdu)); }};
  EXPECT_EQ(put("a.ini", text("[overlap]\n")).state, ground_cfdp::CfdpSender::State::retained);
  EXPECT_EQ(newest().id, 1);
}

TEST_F(UplinkTest, TheActiveFileStaysWhenOldOnesGo) {
  put("a.ini", text("[overlap]\n"));
  MissionParameters mission;
  ASSERT_TRUE(activate(1, mission).ok());
  for (int i = 0; i < 20; ++i) put("b.ini", text("[overlap]\n"));
  UplinkRecord record;
  EXPECT_TRUE(get(rig.store, 1, record).ok());
  EXPECT_TRUE(get(rig.store, 2, record).is(StatusCode::not_found));
  std::int64_t count = 0;
  ASSERT_TRUE(rig.store.count(record_info<UplinkRecord>(), count).ok());
  EXPECT_LE(count, static_cast<std::int64_t>(limits::max_uplink_records) + 1);
}

TEST_F(UplinkTest, AnEofOfAClosedTransferIsAnsweredAgain) {
  const auto sent = put("a.ini", text("[overlap]\n"));
  ASSERT_EQ(sent.state, ground_cfdp::CfdpSender::State::retained);
  for (int i = 0; i < 10; ++i) step();
  cfdp::Pdu eof{.header = sent.header};
  eof.kind = cfdp::PduKind::eof;
  eof.eof.checksum = crc32(text("[overlap]\n"));
  eof.eof.file_bytes = 10;
  Bytes bytes(100);
  std::size_t size = 0;
  ASSERT_TRUE(cfdp::encode(eof, bytes, size).ok());
  ASSERT_TRUE(rig.link->ground().send(std::span<const std::uint8_t>(bytes).first(size)).ok());
  rig.step();
  std::vector<cfdp::PduKind> kinds;
  Bytes buffer(8192);
  std::size_t got = 0;
  while (rig.link->ground().receive(buffer, got).ok()) {
    cfdp::Pdu pdu;
    ASSERT_TRUE(cfdp::decode(std::span<const std::uint8_t>(buffer).first(got), pdu).ok());
    kinds.push_back(pdu.kind);
    if (pdu.kind == cfdp::PduKind::ack) {
      EXPECT_EQ(pdu.ack.status, cfdp::TransactionStatus::terminated);
    }
    if (pdu.kind == cfdp::PduKind::finished) {
      EXPECT_EQ(pdu.finished.file_status, cfdp::FileStatus::retained);
    }
  }
  EXPECT_EQ(kinds, (std::vector<cfdp::PduKind>{cfdp::PduKind::ack, cfdp::PduKind::finished}));
}

TEST_F(UplinkTest, ForgedPdusDoNotHoldTheReceivers) {
  const auto forge = [&](cfdp::Pdu pdu, std::uint64_t source, std::uint64_t sequence) {
    pdu.header = {false, false, false, false, false, false, 2, 2, source, sequence, 1};
    Bytes bytes(300);
    std::size_t size = 0;
    ASSERT_TRUE(cfdp::encode(pdu, bytes, size).ok());
    ASSERT_TRUE(rig.link->ground().send(std::span<const std::uint8_t>(bytes).first(size)).ok());
  };
  const Bytes name = text("x.ini"), octet = text("x");
  cfdp::Pdu metadata, data, end, cancel;
  metadata.metadata.file_bytes = 5000;
  metadata.metadata.source_name = metadata.metadata.destination_name = name;
  data.kind = cfdp::PduKind::file_data;
  data.file_data.bytes = octet;
  end.kind = cancel.kind = cfdp::PduKind::eof;
  end.eof.file_bytes = 100;
  cancel.eof.condition = cfdp::Condition::cancel_request_received;
  const struct {
    const char* what;
    std::vector<cfdp::Pdu> pdus;
    std::uint64_t source;
    int most_steps;
  } cases[] = {{"data of nothing", {data}, 2, 150},      {"ends of nothing", {end}, 2, 150},
               {"cancels of nothing", {cancel}, 2, 150}, {"metadata of nothing", {metadata}, 2, 150},
               {"beginnings", {metadata, data}, 2, 400}, {"another entity", {metadata, data}, 7, 10}};
  std::uint64_t sequence = 1000;
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    for (int i = 0; i < 2; ++i) {
      ++sequence;
      for (const cfdp::Pdu& pdu : c.pdus) forge(pdu, c.source, sequence);
    }
    step();
    EXPECT_EQ(put("a.ini", text("[overlap]\n"), c.most_steps).state, ground_cfdp::CfdpSender::State::retained);
    EXPECT_STREQ(newest().name, "a.ini");
  }
  EXPECT_TRUE(rig.saw(StatusCode::uplink_displaced));
  // A flood of them, of ever new numbers, while a file comes in pieces: who makes progress is left alone.
  std::string content = "[overlap]\n";
  for (int i = 0; i < 1500; ++i) content += "; a line of no meaning, number " + std::to_string(i) + "\n";
  rig.link->faults().loss = 0.1;
  const std::uint64_t own = sender.put("b.ini", text(content), rig.now_s());
  int steps = 0;
  for (; steps < 3000 && sender.transfer(own).state == ground_cfdp::CfdpSender::State::going; ++steps) {
    if (steps > 0) forge(metadata, 2, ++sequence);
    step();
  }
  EXPECT_EQ(sender.transfer(own).state, ground_cfdp::CfdpSender::State::retained);
}

TEST_F(UplinkTest, ADamagedRecordOfAnotherFileStopsNeitherKeepingNorActivating) {
  for (int i = 0; i < 2; ++i) put("a.ini", text("[overlap]\ntarget_overlap = 0.7\n"));
  rig.failing.damage(RecordType::uplink, 1);
  const auto sent = put("b.ini", text("[overlap]\ntarget_overlap = 0.9\n"), 100);
  EXPECT_EQ(sent.state, ground_cfdp::CfdpSender::State::retained);
  MissionParameters mission;
  test::in_transaction(rig.failing,
                       [&] { EXPECT_TRUE(activate_uplink(rig.failing, 3, rig.clock.now(), mission).ok()); });
  EXPECT_EQ(mission.target_overlap, 0.9);
}

TEST_F(UplinkTest, ANumberThatComesAgainWithAnotherFileIsAnotherFile) {
  EXPECT_EQ(put("a.ini", text("[overlap]\n")).state, ground_cfdp::CfdpSender::State::retained);
  for (int i = 0; i < 10; ++i) step();
  for (const char* name : {"b.ini", "b.ini"}) {
    // A sender that has forgotten which numbers it used: another name, then another content.
    sender = ground_cfdp::CfdpSender{{}, [this](const Bytes& pdu) { static_cast<void>(rig.link->ground().send(pdu)); }};
    const std::string content = newest().id == 1 ? "[overlap]\n" : "[overlap]\n;\n";
    EXPECT_EQ(put(name, text(content)).state, ground_cfdp::CfdpSender::State::retained);
    for (int i = 0; i < 10; ++i) step();
    const UplinkRecord record = newest();
    EXPECT_STREQ(record.name, name);
    EXPECT_EQ(record.crc32, crc32(text(content))) << "and not the answer about the file before";
  }
  EXPECT_EQ(newest().id, 3);
}

TEST_F(UplinkTest, MoreTransfersAtOnceThanThereAreReceiversAllArriveInTheEnd) {
  std::vector<std::uint64_t> sequences;
  for (int i = 0; i < 6; ++i) sequences.push_back(sender.put("a.ini", text("[overlap]\n"), rig.now_s()));
  for (int i = 0; i < 3000; ++i) step();
  for (const std::uint64_t sequence : sequences) {
    EXPECT_EQ(sender.transfer(sequence).state, ground_cfdp::CfdpSender::State::retained) << sequence;
  }
}

TEST(MissionText, ReadsNumbersAsTheNearestDouble) {
  for (const char* number : {"0", "-0.0", "1", "0.1", "0.82", "1e-6", "123456.789", "4294967295", "-2.5e3", ".5", "5.",
                             "+7", "1E22", "0.000001234", "999999999999999", "1234567890123456789", "0.3", "2.2e-5"}) {
    double value = -1;
    EXPECT_TRUE(parse_decimal(number, value)) << number;
    EXPECT_EQ(value, std::stod(number)) << number;
  }
  double value = 0;
  for (const char* none :
       {"", ".", "-", "e5", "1e", "1e+", "0x10", "nan", "inf", "1 2", "1.2.3", "1e400", "1e-400", "--1", "1,5"}) {
    EXPECT_FALSE(parse_decimal(none, value)) << none;
  }
}

TEST(MissionText, AnyPiecesGiveTheSameAndAnyBytesAReason) {
  const std::string content =
      "\xEF\xBB\xBF[overlap]\r\n target_overlap=0.9#x\n\n# c\n[ downlink ]\nlink_bytes_per_s = 5";
  for (std::size_t segment = 1; segment <= content.size(); ++segment) {
    MissionParameters mission;
    MissionText reader(mission);
    for (std::size_t at = 0; at < content.size(); at += segment) reader.add(text(content.substr(at, segment)));
    const Status status = reader.finish(mission);
    // "0.9#x": a comment needs a blank before it.
    EXPECT_TRUE(status.is(StatusCode::parameter_out_of_range) && status.b == 2);
    EXPECT_EQ(mission.link_bytes_per_s, MissionParameters{}.link_bytes_per_s) << "all or nothing";
  }
  std::mt19937 random(5);
  for (int trial = 0; trial < 20000; ++trial) {
    Bytes bytes(random() % 80);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>("[]=:;#\n overlap0.9\0\xFF"[random() % 21]);
    MissionParameters mission;
    MissionText reader(mission);
    reader.add(bytes);
    static_cast<void>(reader.finish(mission));
  }
  MissionParameters mission;
  MissionText reader(mission);
  reader.add(Bytes(100000, 'x'));
  EXPECT_TRUE(reader.finish(mission).is(StatusCode::parse_error));
}

}  // namespace
}  // namespace ilp
