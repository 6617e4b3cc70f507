// Telecommands and telemetry against the octets of independent implementations, and against every damage of a packet.
#include "fsw/packets/pus.hpp"

#include <gtest/gtest.h>

#include <array>

#include "fsw/packets/crc16.hpp"
#include "fsw/packets/tailoring.hpp"
#include "tests/support/golden_vectors.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t apid = 0x0EF;

Bytes encoded(const Telecommand& telecommand) {
  std::array<std::uint8_t, 1024> packet{};
  std::size_t bytes = 0;
  EXPECT_TRUE(encode_telecommand(telecommand, packet, bytes).ok());
  return {packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(bytes)};
}
Bytes encoded(const Telemetry& telemetry) {
  std::array<std::uint8_t, 1024> packet{};
  std::size_t bytes = 0;
  EXPECT_TRUE(encode_telemetry(telemetry, TimeFormat{}, packet, bytes).ok());
  return {packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(bytes)};
}

TEST(Pus, PingOfTheProfile) {
  Telecommand ping;
  ping.primary.apid = apid;
  ping.service = 17;
  ping.subtype = 1;
  ping.source = 1;
  const Bytes packet = from_hex("18efc00000062f1101000190eb");
  EXPECT_EQ(encoded(ping), packet);
  Telecommand back;
  ASSERT_TRUE(decode_telecommand(packet, apid, back).ok());
  EXPECT_EQ(back.service, 17);
  EXPECT_EQ(back.subtype, 1);
  EXPECT_EQ(back.ack_flags, 0x0F);
  EXPECT_EQ(back.request(), (RequestId{0x18EFC000, 1}));
}

TEST(Pus, CompletionOfTheProfile) {
  const Bytes packet = from_hex("08efc00200132001070002000140610500000008 18efc017 dbf7");
  Telemetry report;
  ASSERT_TRUE(decode_telemetry(packet, apid, TimeFormat{}, report).ok());
  EXPECT_EQ(report.service, 1);
  EXPECT_EQ(report.subtype, 7);
  EXPECT_EQ(report.counter, 2);
  EXPECT_EQ(report.destination, 1);
  EXPECT_EQ(report.time, 24837 * seconds_per_day * ns_per_s + 8 * ns_per_ms);
  EXPECT_EQ(Bytes(report.data.begin(), report.data.end()), from_hex("18efc017"));
  EXPECT_EQ(encoded(report), packet);
}

TEST(Pus, TelecommandsOfIndependentImplementations) {
  for (const char* file : {"tc.hex", "tc_fsfw.hex"}) {
    const auto vectors = golden_vectors(file);
    if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/" << file;
    for (const auto& [name, packet] : vectors) {
      Telecommand telecommand;
      const Status status = decode_telecommand(packet, apid, telecommand);
      ASSERT_TRUE(status.ok()) << name << ": " << status_name(status.code);
      int service = 0, subtype = 0;  // the names are tc_SERVICE_SUBTYPE...
      ASSERT_EQ(std::sscanf(name.c_str() + name.find('_'), "_%d_%d", &service, &subtype), 2) << name;
      EXPECT_EQ(telecommand.service, service) << name;
      EXPECT_EQ(telecommand.subtype, subtype) << name;
      EXPECT_EQ(encoded(telecommand), packet) << name;
    }
  }
}

TEST(Pus, AcknowledgementFlagsAndCountsOfTheVectors) {
  const auto vectors = golden_vectors("tc.hex");
  if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/tc.hex";
  const auto flags = [&](const char* name) {
    Telecommand telecommand;
    EXPECT_TRUE(decode_telecommand(vectors.at(name), apid, telecommand).ok());
    return telecommand;
  };
  EXPECT_EQ(flags("tc_17_1_noack").ack_flags, 0);
  EXPECT_EQ(flags("tc_17_1_accept").ack_flags, ack::acceptance);
  EXPECT_EQ(flags("tc_17_1_complete").ack_flags, ack::completion);
  EXPECT_EQ(flags("tc_17_1_seq16383").primary.sequence_count, 16383);
  EXPECT_EQ(flags("tc_11_4").source, 1);
}

TEST(Pus, TelemetryOfIndependentImplementations) {
  const auto vectors = golden_vectors("tm.hex");
  if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/tm.hex";
  for (const auto& [name, packet] : vectors) {
    Telemetry telemetry;
    const Status status = decode_telemetry(packet, apid, TimeFormat{}, telemetry);
    ASSERT_TRUE(status.ok()) << name << ": " << status_name(status.code);
    int service = 0, subtype = 0;
    ASSERT_EQ(std::sscanf(name.c_str(), "tm_%d_%d", &service, &subtype), 2) << name;
    EXPECT_EQ(telemetry.service, service) << name;
    EXPECT_EQ(telemetry.subtype, subtype) << name;
    EXPECT_EQ(encoded(telemetry), packet) << name;
  }
}

TEST(Pus, BadTelecommandsAreRejectedForTheirReason) {
  const std::map<std::string, StatusCode> reasons = {
      {"bad_crc", StatusCode::packet_crc},
      {"bad_bit", StatusCode::packet_crc},
      {"bad_pus_a", StatusCode::packet_pus_version},
      {"bad_ccsds_version", StatusCode::packet_version},
      {"bad_type_tm", StatusCode::packet_type},
      {"bad_no_sec_hdr", StatusCode::packet_no_secondary_header},
      {"bad_seq_flags", StatusCode::packet_segmented},
      {"bad_len_plus1", StatusCode::packet_length},
      {"bad_len_minus1", StatusCode::packet_length},
      {"bad_truncated", StatusCode::packet_length},
  };
  const auto vectors = golden_vectors("bad_tc.hex");
  if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/bad_tc.hex";
  for (const auto& [name, packet] : vectors) {
    Telecommand telecommand;
    const auto reason = reasons.find(name);
    // The others are well-formed packets: their fault is in what they ask.
    const StatusCode expected = reason == reasons.end() ? StatusCode::ok : reason->second;
    EXPECT_STREQ(status_name(decode_telecommand(packet, apid, telecommand).code), status_name(expected)) << name;
  }
}

TEST(Pus, AnotherApplicationIsRejected) {
  Telecommand telecommand;
  const Status status = decode_telecommand(from_hex("18efc00000062f1101000190eb"), 0x0EE, telecommand);
  EXPECT_TRUE(status.is(StatusCode::packet_apid));
  EXPECT_EQ(status.a, 0x0EF);
}

TEST(Pus, EveryFlippedBitIsRejected) {
  const Bytes packet = from_hex("18efc00700182f140300010003000100500002 3f000000 0003 000186a0 1cb9");
  Telecommand telecommand;
  ASSERT_TRUE(decode_telecommand(packet, apid, telecommand).ok());
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    Bytes flipped = packet;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (0x80U >> bit % 8));
    EXPECT_FALSE(decode_telecommand(flipped, apid, telecommand).ok()) << "bit " << bit;
  }
}

TEST(Pus, EveryLengthIsAnswered) {
  // A packet of every length, right but for its length, and right.
  Bytes data(2000, 0x5A);
  for (std::size_t size = 0; size < 1000; ++size) {
    Telecommand sent;
    sent.primary.apid = apid;
    sent.data = std::span<const std::uint8_t>(data).first(size);
    const Bytes packet = encoded(sent);
    EXPECT_EQ(packet.size(), telecommand_overhead_bytes + size);
    Telecommand back;
    ASSERT_TRUE(decode_telecommand(packet, apid, back).ok());
    EXPECT_EQ(back.data.size(), size);
  }
  const Bytes packet = from_hex("18efc00000062f1101000190eb");
  for (std::size_t size = 0; size < packet.size(); ++size) {
    Telecommand back;
    const Status status = decode_telecommand(std::span<const std::uint8_t>(packet).first(size), apid, back);
    EXPECT_TRUE(status.is(size < 6 ? StatusCode::packet_too_short : StatusCode::packet_length)) << size;
  }
  for (std::size_t length = 0; length < 7; ++length) {
    Bytes cut(6 + length, 0);
    cut[0] = 0x18, cut[1] = 0xEF, cut[2] = 0xC0;
    cut[5] = static_cast<std::uint8_t>(length - 1);
    Telecommand back;
    const Status status = decode_telecommand(cut, apid, back);
    EXPECT_TRUE(status.is(length == 0 ? StatusCode::packet_length : StatusCode::packet_too_short)) << length;
  }
}

TEST(Pus, NoRoomForAPacketIsAStatus) {
  Telecommand ping;
  std::array<std::uint8_t, 13> packet{};
  std::size_t bytes = 0;
  EXPECT_TRUE(encode_telecommand(ping, packet, bytes).ok());
  for (std::size_t capacity = 0; capacity < packet.size(); ++capacity) {
    EXPECT_TRUE(encode_telecommand(ping, std::span(packet).first(capacity), bytes).is(StatusCode::capacity_exceeded));
  }
  const Bytes much(70000, 0);
  Bytes large(80000, 0);
  ping.data = much;
  EXPECT_TRUE(encode_telecommand(ping, large, bytes).is(StatusCode::capacity_exceeded));
}

TEST(Pus, PacketsAreCutOutOfAStream) {
  const Bytes ping = from_hex("18efc00000062f1101000190eb");
  Bytes stream = ping;
  const Bytes another = from_hex("18efc00400082f1103000100ef2fc8");
  stream.insert(stream.end(), another.begin(), another.end());
  std::span<const std::uint8_t> packet;
  ASSERT_TRUE(first_packet(stream, packet).ok());
  EXPECT_EQ(Bytes(packet.begin(), packet.end()), ping);
  ASSERT_TRUE(first_packet(std::span<const std::uint8_t>(stream).subspan(packet.size()), packet).ok());
  EXPECT_EQ(Bytes(packet.begin(), packet.end()), another);
  for (std::size_t size = 0; size < ping.size(); ++size) {
    EXPECT_TRUE(first_packet(std::span<const std::uint8_t>(ping).first(size), packet).is(StatusCode::packet_too_short));
  }
}

TEST(Tailoring, PresetsCarryTheWidthsOfTheirClients) {
  const auto presets = tailorings();
  EXPECT_STREQ(presets[0].name, "standard");
  EXPECT_STREQ(presets[1].name, "fsfw");
  EXPECT_EQ(presets[1].insert_count, 0);
  EXPECT_STREQ(presets[2].name, "yamcs");
  EXPECT_EQ(time_bytes(presets[2].time), 8U);
  EXPECT_EQ(p_field_of(presets[2].time), 0x2F);
  EXPECT_STREQ(tailoring_of(static_cast<GroundSystem>(17), false, 0).name, "standard");
  EXPECT_STREQ(tailoring_of(static_cast<GroundSystem>(255), false, 0).name, "standard");
  EXPECT_EQ(tailoring_of(GroundSystem::standard, true, 1e9).time.agency_epoch, 1'000'000'000 * ns_per_s);
}

}  // namespace
}  // namespace ilp
