// Files of keys: the ground takes those that the flight takes.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/packets/authentication.hpp"
#include "sim/host/key_file.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

const std::string key_a = "000102030405060708090A0b0c0d0e0f", key_b(64, 'e');

class KeyFile : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& text) {
    const std::filesystem::path path = folder_ / "keys";
    std::ofstream(path) << text;
    ::chmod(path.c_str(), 0600);
    return path;
  }
  std::string refusal(const std::string& text, std::uint16_t spi = 0) {
    return test::error_of([&] { (void)read_key_file(file(text), spi); });
  }
  test::ScratchFolder folder_;
};

TEST_F(KeyFile, TheFirstKeyOrThatOfAnSpiIsRead) {
  const std::string text = "# keys\n\n  7 " + key_a + " # telecommands\r\n9 " + key_b + "\n";
  Authenticator flight;
  ASSERT_TRUE(flight.add_keys(text).ok());
  const FileKey first = read_key_file(file(text));
  EXPECT_EQ(first.spi, 7);
  EXPECT_EQ(first.octets, std::vector<std::uint8_t>(flight.first_key().begin(), flight.first_key().end()));
  EXPECT_EQ(read_key_file(file(text), 9).octets, std::vector<std::uint8_t>(32, 0xEE));
  EXPECT_TRUE(test::says(refusal(text, 8), "has no key of SPI 8"));
  EXPECT_TRUE(test::says(refusal("# none\n"), "has no key"));
}

TEST_F(KeyFile, ALineThatTheFlightRefusesIsNotPassedOver) {
  const std::vector<std::string> lines = {"70000 " + key_a,           "0 " + key_a,  "7 0001",
                                          "7 " + key_a + "0",         "7 x" + key_a, "7",
                                          "7 " + key_a + " " + key_a, key_a};
  for (const std::string& line : lines) {
    const std::string text = line + "\n9 " + key_b + "\n";
    Authenticator flight;
    EXPECT_FALSE(flight.add_keys(text).ok()) << line;
    EXPECT_TRUE(test::says(refusal(text), "a line is an SPI and 16 to 64 octets in hexadecimal")) << line;
  }
  EXPECT_TRUE(test::says(refusal(std::string(5000, '#')), "less than 4 KiB"));
}

TEST_F(KeyFile, OthersMustNotReadIt) {
  const std::filesystem::path path = file("7 " + key_a + "\n");
  ::chmod(path.c_str(), 0644);
  EXPECT_TRUE(test::says(test::error_of([&] { (void)read_key_file(path); }), "run chmod 600"));
  EXPECT_TRUE(
      test::says(test::error_of([&] { (void)read_key_file(folder_ / "none"); }), "cannot read the file of keys"));
}

}  // namespace
}  // namespace ilp::host
