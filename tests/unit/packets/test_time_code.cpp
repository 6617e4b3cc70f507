// Time codes against the octets of independent implementations and against the calendar.
#include "fsw/packets/time_code.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "tests/support/golden_vectors.hpp"

namespace ilp {
namespace {

constexpr std::int64_t day_ns = seconds_per_day * ns_per_s;
constexpr UtcNs year_2000 = 15340 * day_ns;
constexpr UtcNs year_2026 = 24837 * day_ns;

TimeFormat cds(std::uint8_t days = 2, std::uint8_t sub_ms = 0, bool p_field = true) {
  TimeFormat format{.p_field = p_field, .day_octets = days, .sub_ms_octets = sub_ms};
  return format;
}
TimeFormat cuc(TimeCode code, std::uint8_t fine, bool p_field = true) {
  TimeFormat format{.code = code, .p_field = p_field, .fine_octets = fine, .agency_epoch = year_2000};
  return format;
}

Bytes encoded(const TimeFormat& format, UtcNs utc) {
  std::array<std::uint8_t, max_time_bytes> octets{};
  ByteWriter out(octets);
  EXPECT_TRUE(encode_time(format, utc, out).ok());
  EXPECT_TRUE(out.ok());
  EXPECT_EQ(out.size(), time_bytes(format));
  return {out.written().begin(), out.written().end()};
}
UtcNs decoded(const TimeFormat& format, const Bytes& octets) {
  ByteReader in(octets);
  UtcNs utc = -1;
  const Status status = decode_time(format, in, utc);
  EXPECT_TRUE(status.ok()) << status_name(status.code);
  EXPECT_EQ(in.left(), 0U);
  return utc;
}

TEST(TimeCode, OctetsOfTheProfile) {
  const UtcNs instant = year_2026 + ns_per_ms;
  EXPECT_EQ(encoded(cds(), instant), from_hex("40610500000001"));
  EXPECT_EQ(encoded(cuc(TimeCode::cuc_agency, 3), instant), from_hex("2f30e87585004189"));
  EXPECT_EQ(encoded(cuc(TimeCode::cuc_ccsds, 2), instant), from_hex("1e7fe817a50042"));
  EXPECT_EQ(decoded(cds(), from_hex("40610500000001")), instant);
}

TEST(TimeCode, TheNearestTimeOfAFormatCanBeEncoded) {
  const UtcNs times[] = {0, 1, year_2000 - 1, year_2000, year_2026, year_2026 * 3, INT64_MAX};
  TimeFormat of_the_future = cuc(TimeCode::cuc_agency, 3);
  of_the_future.agency_epoch = year_2026 + 1000 * day_ns;
  TimeFormat short_cuc = cuc(TimeCode::cuc_agency, 0);
  short_cuc.coarse_octets = 1;
  for (const TimeFormat& format :
       {cds(), cds(3, 4), cuc(TimeCode::cuc_agency, 3), cuc(TimeCode::cuc_ccsds, 2), of_the_future, short_cuc}) {
    for (const UtcNs time : times) {
      std::array<std::uint8_t, max_time_bytes> octets{};
      ByteWriter out(octets);
      const UtcNs nearest = nearest_time(format, time);
      EXPECT_TRUE(encode_time(format, nearest, out).ok()) << time;
      ByteWriter again(octets);
      if (time != nearest) {
        EXPECT_FALSE(encode_time(format, time, again).ok()) << time << " could be told itself";
      }
    }
  }
  EXPECT_EQ(nearest_time(of_the_future, year_2026), of_the_future.agency_epoch);
  EXPECT_EQ(nearest_time(cds(), year_2026), year_2026);
}

TEST(TimeCode, OctetsOfIndependentImplementations) {
  std::ifstream in(golden_folder() / "time.hex");
  if (!in) GTEST_SKIP() << "no ../shared/data/tctm/time.hex";
  const std::map<std::string, TimeFormat> formats = {
      {"cds_p", cds()},
      {"cds_nop", cds(2, 0, false)},
      {"cds_p_us", cds(2, 2)},
      {"cds_p_24", cds(3)},
      {"cuc_4_2", cuc(TimeCode::cuc_ccsds, 2, false)},
      {"cuc_4_2_p", cuc(TimeCode::cuc_ccsds, 2)},
      {"cuc_4_3_p", cuc(TimeCode::cuc_ccsds, 3)},
      {"cuc_4_3_p_agency2000", cuc(TimeCode::cuc_agency, 3)},
  };
  int lines = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string name, iso, hex;
    words >> name >> iso >> hex;
    ASSERT_EQ(formats.count(name), 1U) << name;
    const TimeFormat& format = formats.at(name);
    int year = 0, month = 0, day = 0, hour = 0, minute = 0;
    double second = 0;
    ASSERT_EQ(std::sscanf(iso.c_str(), "%d-%d-%dT%d:%d:%lfZ", &year, &month, &day, &hour, &minute, &second), 6);
    std::tm calendar{};
    calendar.tm_year = year - 1900;
    calendar.tm_mon = month - 1;
    calendar.tm_mday = day;
    const std::int64_t days = timegm(&calendar) / seconds_per_day + 4383;  // 1958-01-01 to 1970-01-01
    const UtcNs utc = days * day_ns + (hour * 3600 + minute * 60) * ns_per_s +
                      static_cast<std::int64_t>(second * 1000 + 0.5) * ns_per_ms;
    EXPECT_EQ(encoded(format, utc), from_hex(hex)) << line;
    const UtcNs back = decoded(format, from_hex(hex));
    const double resolution =
        format.code == TimeCode::cds ? 0 : 1e9 / static_cast<double>(1U << 8U * format.fine_octets);
    EXPECT_LE(std::abs(static_cast<double>(back - utc)), resolution / 2 + 1) << line;
    EXPECT_EQ(encoded(format, back), from_hex(hex)) << line;
    ++lines;
  }
  EXPECT_EQ(lines, 16);
}

TEST(TimeCode, LeapSecondsComeBetweenUtcAndTai) {
  EXPECT_EQ(leap_seconds(year_2000 - 1), 32);
  EXPECT_EQ(leap_seconds(year_2026), 37);
  const UtcNs year_2017 = 21550 * day_ns;
  EXPECT_EQ(tai_of_utc(year_2017) - tai_of_utc(year_2017 - ns_per_s), 2 * ns_per_s);
  EXPECT_EQ(utc_of_tai(tai_of_utc(year_2017) - ns_per_s / 2), year_2017);
  for (UtcNs utc = 0; utc < 30000 * day_ns; utc += 11 * day_ns + 12345678901)
    EXPECT_EQ(utc_of_tai(tai_of_utc(utc)), utc);
}

TEST(TimeCode, EveryStringOfOctetsIsATimeOrARejection) {
  std::array<std::uint8_t, 13> octets{};
  for (int p_field = 0; p_field < 256; ++p_field) {
    for (const int fill : {0x00, 0x01, 0x7F, 0xFF}) {
      octets.fill(static_cast<std::uint8_t>(fill));
      octets[0] = static_cast<std::uint8_t>(p_field);
      for (std::size_t size = 0; size <= octets.size(); ++size) {
        ByteReader in(std::span<const std::uint8_t>(octets).first(size));
        UtcNs utc = -1;
        const Status status = decode_time(cds(), in, utc);
        if (status.ok()) {
          EXPECT_GE(utc, 0) << p_field;
        } else {
          EXPECT_TRUE(status.is(StatusCode::time_code_unknown) || status.is(StatusCode::packet_too_short) ||
                      status.is(StatusCode::time_out_of_range));
        }
      }
    }
  }
}

TEST(TimeCode, WhatAFormatCannotHoldIsRefused) {
  std::array<std::uint8_t, max_time_bytes> octets{};
  ByteWriter out(octets);
  EXPECT_TRUE(encode_time(cds(), 65536 * day_ns, out).is(StatusCode::time_out_of_range));
  EXPECT_TRUE(encode_time(cds(), -1, out).is(StatusCode::time_out_of_range));
  EXPECT_TRUE(encode_time(cuc(TimeCode::cuc_agency, 3), year_2000 - ns_per_s, out).is(StatusCode::time_out_of_range));
  EXPECT_TRUE(encode_time(cds(3), 65536 * day_ns, out).ok());
  const Bytes beyond_the_day = from_hex("4061050fffffff");
  ByteReader in(beyond_the_day);
  UtcNs utc = 0;
  EXPECT_TRUE(decode_time(cds(), in, utc).is(StatusCode::time_out_of_range));
}

TEST(TimeCode, RoundingCarriesIntoTheSecond) {
  EXPECT_EQ(encoded(cuc(TimeCode::cuc_agency, 1), year_2000 + ns_per_s - 1), from_hex("2d0000000100"));
}

TEST(TimeCode, MissionTimeRunsThroughALeapSecond) {
  const MissionTime time(21549.0 * 86400);  // the day before 2017-01-01, which was a second longer
  EXPECT_EQ(time.utc(0), 21549 * day_ns);
  EXPECT_EQ(time.utc(86400 * ns_per_s + ns_per_s), 21550 * day_ns);
  EXPECT_EQ(time.mission(21550 * day_ns), 86401 * ns_per_s);
  const MissionTime fraction(1e9 + 0.25);
  EXPECT_EQ(fraction.utc(5), 1'000'000'000 * ns_per_s + 250 * ns_per_ms + 5);
  EXPECT_EQ(fraction.utc(-4'000'000'000'000'000'000), 0);
}

}  // namespace
}  // namespace ilp
