// Metadata lines: exact round trips of numbers, checked against the C library's strtod, and hostile text.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "fsw/base/rng.hpp"
#include "fsw/vision/codec/metadata.hpp"

namespace ilp {
namespace {

std::string written(double value) {
  std::array<std::uint8_t, 100> buffer{};
  MetadataWriter writer(buffer);
  writer.real("x", value);
  EXPECT_TRUE(writer.status().ok());
  const auto bytes = writer.bytes();
  return {bytes.begin() + 2, bytes.end() - 1};
}

Status read_real(const std::string& text, double& value) {
  const std::string line = "x=" + text + "\n";
  const MetadataReader reader({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
  return reader.real("x", value);
}

void expect_exact(double value) {
  const std::string text = written(value);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)), std::bit_cast<std::uint64_t>(value))
      << text;
  double back = 0;
  ASSERT_TRUE(read_real(text, back).ok()) << text;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(back), std::bit_cast<std::uint64_t>(value)) << text;
}

TEST(Metadata, PlainNumbersReadAsPeopleWriteThem) {
  EXPECT_EQ(written(0), "0");
  EXPECT_EQ(written(640), "640");
  EXPECT_EQ(written(-0.25), "-0.25");
  EXPECT_EQ(written(0.1), "0.1");
  EXPECT_EQ(written(1182.3), "1182.3");
  EXPECT_EQ(written(0.003), "0.003");
}

TEST(Metadata, EveryDoubleSurvives) {
  using Limits = std::numeric_limits<double>;
  for (const double value : {0.0, -0.0, 1.0 / 3, -2.0 / 3, 1e300, -1e-300, Limits::max(), Limits::min(),
                             Limits::denorm_min(), -3 * Limits::denorm_min(), 9007199254740991.0, 9007199254740993.0,
                             123456789.123456789, 1e15, 1e22, 1e23, Limits::infinity(), -Limits::infinity()}) {
    expect_exact(value);
  }
  Rng rng(3);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = (static_cast<std::uint64_t>(rng.next()) << 32U) | rng.next();
    const auto value = std::bit_cast<double>(bits);
    if (!std::isnan(value)) expect_exact(value);
    expect_exact(static_cast<double>(rng.below(1000000)) / 1000.0);
  }
  double nan = 0;
  ASSERT_TRUE(read_real(written(Limits::quiet_NaN()), nan).ok());
  EXPECT_TRUE(std::isnan(nan));
}

TEST(Metadata, KeysFindTheirValues) {
  std::array<std::uint8_t, 400> buffer{};
  MetadataWriter writer(buffer);
  writer.text("scene", "Arsia Mons = north, 5%");
  writer.integer("keyframe", -17);
  writer.integer("lowest", std::numeric_limits<std::int64_t>::min());
  writer.integer("highest", std::numeric_limits<std::int64_t>::max());
  const std::array<double, 3> centre = {1.5, -2, 1.0 / 3};
  writer.reals("centre", centre);
  ASSERT_TRUE(writer.status().ok());

  const MetadataReader reader(writer.bytes());
  std::string_view text;
  std::int64_t integer = 0;
  std::array<double, 3> back{};
  ASSERT_TRUE(reader.text("scene", text).ok());
  EXPECT_EQ(text, "Arsia Mons = north, 5%");
  ASSERT_TRUE(reader.integer("keyframe", integer).ok());
  EXPECT_EQ(integer, -17);
  ASSERT_TRUE(reader.integer("lowest", integer).ok());
  EXPECT_EQ(integer, std::numeric_limits<std::int64_t>::min());
  ASSERT_TRUE(reader.integer("highest", integer).ok());
  EXPECT_EQ(integer, std::numeric_limits<std::int64_t>::max());
  ASSERT_TRUE(reader.reals("centre", back).ok());
  EXPECT_EQ(back, centre);
  EXPECT_TRUE(reader.text("centr", text).is(StatusCode::not_found));
  double one = 0;
  EXPECT_TRUE(reader.real("centre", one).is(StatusCode::parse_error)) << "three numbers are not one";
  std::array<double, 4> four{};
  EXPECT_TRUE(reader.reals("centre", four).is(StatusCode::parse_error));
}

TEST(Metadata, FullBufferTakesTheLineBack) {
  std::array<std::uint8_t, 10> buffer{};
  MetadataWriter writer(buffer);
  writer.integer("a", 1);
  writer.text("name", "too long to fit");
  EXPECT_TRUE(writer.status().is(StatusCode::capacity_exceeded));
  writer.integer("b", 2);
  EXPECT_EQ(std::string(writer.bytes().begin(), writer.bytes().end()), "a=1\n");
}

TEST(Metadata, RefusesWhatWouldBreakTheLines) {
  std::array<std::uint8_t, 100> buffer{};
  for (const auto& [key, value] : {std::pair{"a b", "1"}, std::pair{"", "1"}, std::pair{"a", "1\nb=2"}}) {
    MetadataWriter writer(buffer);
    writer.text(key, value);
    EXPECT_TRUE(writer.status().is(StatusCode::invalid_argument));
    EXPECT_TRUE(writer.bytes().empty());
  }
}

TEST(Metadata, HostileNumbersAreErrors) {
  for (const char* text : {"", "-", ".", "1e5", "1.2.3", "0x", "0x1", "0x2.0p+1", "0x1.p", "0x1.0p+99999999999",
                           "0x1.00000000000000000p+1", "99999999999999999999", "1 ", " 1", "0.00000000000000000000001",
                           "infinity", "--1", "0x1.8p+1024"}) {
    double value = 0;
    EXPECT_TRUE(read_real(text, value).is(StatusCode::parse_error)) << text;
  }
  const std::string line = "i=9223372036854775808\nj=-9223372036854775809\nk=1x\n";
  const MetadataReader reader({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
  std::int64_t integer = 0;
  for (const char* key : {"i", "j", "k"}) EXPECT_TRUE(reader.integer(key, integer).is(StatusCode::parse_error)) << key;
}

TEST(Metadata, RandomBytesNeverGoOutOfBounds) {
  Rng rng(11);
  for (int i = 0; i < 3000; ++i) {
    std::string bytes(rng.below(60), '\0');
    const char alphabet[] = "ax=\n.0p+-\x80\xff";
    for (char& c : bytes) c = alphabet[rng.below(sizeof(alphabet))];
    const MetadataReader reader({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    std::size_t position = 0;
    std::string_view key;
    std::string_view value;
    std::size_t lines = 0;
    while (reader.next(position, key, value).ok()) ++lines;
    EXPECT_LE(lines, bytes.size());
    double x = 0;
    static_cast<void>(reader.real("x", x));
  }
}

}  // namespace
}  // namespace ilp
