#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "fsw/base/crc.hpp"

namespace ilp {
namespace {

/// By the definition: a bit at a time.
std::uint32_t by_definition(std::span<const std::uint8_t> bytes, std::uint32_t polynomial, std::uint32_t crc = 0) {
  std::uint32_t value = ~crc;
  for (const std::uint8_t byte : bytes) {
    value ^= byte;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? polynomial : 0U);
  }
  return ~value;
}

/// CRC-32C of the piece, at once and in two parts.
void expect_defined(std::span<const std::uint8_t> chunk) {
  ASSERT_EQ(crc32c(chunk), by_definition(chunk, 0x82F63B78U)) << chunk.size() << " bytes";
  const std::size_t cut = chunk.size() * 3 / 7;
  ASSERT_EQ(crc32c(chunk.subspan(cut), crc32c(chunk.first(cut))), crc32c(chunk)) << chunk.size() << " bytes";
}

std::vector<std::uint8_t> random_bytes(std::size_t count) {
  std::mt19937 random(5);
  std::vector<std::uint8_t> bytes(count);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

TEST(Crc, HasThePublishedCheckValues) {
  const std::vector<std::uint8_t> digits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc32(digits), 0xCBF43926U);
  EXPECT_EQ(crc32c(digits), 0xE3069283U);
  EXPECT_EQ(crc32({}), 0U);
}

TEST(Crc, IsWhatTheDefinitionSaysForEveryLengthAndPlaceAndContinues) {
  const std::vector<std::uint8_t> bytes = random_bytes(100);
  for (std::size_t begin = 0; begin < 9; ++begin) {
    for (std::size_t length = 0; begin + length <= bytes.size(); ++length) {
      const auto chunk = std::span<const std::uint8_t>(bytes).subspan(begin, length);
      ASSERT_EQ(crc32(chunk), by_definition(chunk, 0xEDB88320U));
      ASSERT_EQ(crc32c(chunk), by_definition(chunk, 0x82F63B78U));
      const std::size_t cut = length * 3 / 7;
      ASSERT_EQ(crc32(chunk.subspan(cut), crc32(chunk.first(cut))), crc32(chunk));
    }
  }
}

TEST(Crc, TheProcessorsInstructionsComputeTheSame) {
  if (!may_have_crc32c_instructions()) GTEST_SKIP() << "this processor has none";
  const std::vector<std::uint8_t> bytes = random_bytes(100);
  for (const bool use : {false, true}) {
    SCOPED_TRACE(use ? "by instructions" : "by tables");
    use_crc32c_instructions(use);
    for (std::size_t begin = 0; begin < 9; ++begin) {
      for (std::size_t length = 0; begin + length <= bytes.size(); ++length) {
        ASSERT_NO_FATAL_FAILURE(expect_defined(std::span(bytes).subspan(begin, length)));
      }
    }
  }
}

// From 4080 bytes on the instructions sum three streams at once, which are joined.
TEST(Crc, StreamsAreJoinedAtEveryLength) {
  if (!may_have_crc32c_instructions()) GTEST_SKIP() << "this processor has no instructions for CRC-32C";
  const std::vector<std::uint8_t> bytes = random_bytes(20000);
  use_crc32c_instructions(true);
  for (const std::size_t length : {4079, 4080, 4081, 4096, 8159, 8160, 8191, 12240, 19990}) {
    for (const std::size_t begin : {0, 1, 10}) {
      ASSERT_NO_FATAL_FAILURE(expect_defined(std::span(bytes).subspan(begin, length)));
    }
  }
}

TEST(Crc, TellsWhichBitHasFlipped) {
  std::vector<std::uint8_t> bytes(300);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i);
  const std::uint32_t before = crc32c(bytes);
  const std::size_t tail = 290;
  for (std::size_t bit = 0; bit < 8 * tail; ++bit) {
    std::uint8_t& byte = bytes[bytes.size() - tail + bit / 8];
    byte ^= static_cast<std::uint8_t>(1U << bit % 8);
    ASSERT_EQ(crc32c_flipped_bit(tail, before ^ crc32c(bytes)), bit);
    byte ^= static_cast<std::uint8_t>(1U << bit % 8);
  }
  bytes[5] ^= 1;
  EXPECT_EQ(crc32c_flipped_bit(tail, before ^ crc32c(bytes)), 8 * tail) << "a bit outside";
  bytes[200] ^= 1;
  bytes[250] ^= 1;
  EXPECT_EQ(crc32c_flipped_bit(tail, before ^ crc32c(bytes)), 8 * tail) << "three bits";
}

}  // namespace
}  // namespace ilp
