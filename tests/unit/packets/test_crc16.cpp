#include <gtest/gtest.h>

#include <array>

#include "fsw/packets/crc16.hpp"

namespace ilp {
namespace {

TEST(Crc16, HasTheCheckValueOfTheStandard) {
  constexpr std::array<std::uint8_t, 9> digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc16(digits), 0x29B1);
  EXPECT_EQ(crc16(std::span(digits).subspan(4), crc16(std::span(digits).first(4))), 0x29B1);
}

TEST(Crc16, IsZeroOverAPacketAndItsOwn) {
  // TC[17,1], APID 0x0EF, as an independent library writes it.
  constexpr std::array<std::uint8_t, 13> packet{0x18, 0xEF, 0xC0, 0x00, 0x00, 0x06, 0x2F,
                                                0x11, 0x01, 0x00, 0x01, 0x90, 0xEB};
  EXPECT_EQ(crc16(packet), 0);
  EXPECT_EQ(crc16(std::span(packet).first(11)), 0x90EB);
}

}  // namespace
}  // namespace ilp
