// The directory of a map as bytes: what was written is read, and nothing else.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/packets/hmac_sha256.hpp"
#include "tests/unit/maps/known_map.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t end_bytes = 4 + 32;
const Bytes key(32, 0x5A);

std::unique_ptr<MapDirectory> directory_with_tiles() {
  auto directory = test::known_directory();
  for (std::uint16_t layer = 0; layer < 2; ++layer) {
    for (std::uint16_t row = 0; row < directory->layers[layer].rows; ++row) {
      for (std::uint16_t column = 0; column < directory->layers[layer].columns; column += 2) {
        MapTileEntry entry;
        entry.digest = 0xABCDEF0123456789U + row * 1000U + column;
        entry.bytes = static_cast<std::uint16_t>(5000 + row);
        entry.layer = layer;
        entry.row = row;
        entry.column = column;
        EXPECT_TRUE(directory->tiles.push_back(entry));
      }
    }
  }
  return directory;
}

/// Puts the checksum right, so that what it guards is looked at.
void restore_checksum(Bytes& bytes) {
  const std::span<const std::uint8_t> content(bytes.data(), bytes.size() - end_bytes);
  store_little_endian(crc32(content), bytes.data() + content.size());
}

TEST(MapDirectory, IsReadAsItWasWritten) {
  const auto directory = directory_with_tiles();
  const Bytes bytes = test::bytes_of(*directory);
  EXPECT_EQ(bytes.size(), 152 + 16 * directory->tiles.size() + end_bytes);
  const auto read = std::make_unique<MapDirectory>();
  ASSERT_TRUE(parse_map_directory(bytes, {}, *read).ok());
  EXPECT_EQ(read->id, 0x123456789ABCDEF0U);
  EXPECT_EQ(read->body, Body::mars);
  EXPECT_EQ(read->light, MapLight::flat);
  EXPECT_EQ(read->longitude_rad, 2.4);
  EXPECT_EQ(read->latitude_rad, -0.08);
  EXPECT_EQ(read->sun_azimuth_rad, 2.2);
  EXPECT_EQ(read->sun_elevation_rad, 0.55);
  EXPECT_EQ(read->ambient, 0.25);
  EXPECT_EQ(read->image_sigma, 2);
  EXPECT_EQ(read->height_sigma_m, 0.75);
  EXPECT_EQ(read->place_sigma_m, 100);
  ASSERT_EQ(read->layer_count, 2U);
  EXPECT_EQ(read->layers[0].pixel_m, 2.5);
  EXPECT_EQ(read->layers[1].x0_m, -1000);
  EXPECT_EQ(read->layers[1].y0_m, 2000);
  EXPECT_EQ(read->layers[0].columns, 8);
  EXPECT_EQ(read->layers[0].rows, 6);
  ASSERT_EQ(read->tiles.size(), directory->tiles.size());
  for (std::size_t i = 0; i < read->tiles.size(); ++i) {
    EXPECT_EQ(read->tiles[i].digest, directory->tiles[i].digest);
    EXPECT_EQ(read->tiles[i].bytes, directory->tiles[i].bytes);
  }
}

TEST(MapDirectory, FindsItsTiles) {
  const auto directory = directory_with_tiles();
  const std::size_t none = directory->tiles.size();
  for (std::size_t i = 0; i < none; ++i) {
    const MapTileEntry& entry = directory->tiles[i];
    EXPECT_EQ(find_map_tile(*directory, entry.layer, entry.row, entry.column), i);
  }
  EXPECT_EQ(find_map_tile(*directory, 0, 0, 1), none);
  EXPECT_EQ(find_map_tile(*directory, 0, -1, 0), none);
  EXPECT_EQ(find_map_tile(*directory, 0, 0, 65536), none);
  EXPECT_EQ(find_map_tile(*directory, 2, 0, 0), none);
}

TEST(MapDirectory, IsBelievedOnlyWithTheKeyOfTheFlight) {
  const auto directory = directory_with_tiles();
  const auto read = std::make_unique<MapDirectory>();
  const Bytes bytes = test::bytes_of(*directory, key);
  EXPECT_TRUE(parse_map_directory(bytes, key, *read).ok());
  EXPECT_TRUE(parse_map_directory(bytes, {}, *read).ok()) << "a flight without keys";
  EXPECT_TRUE(parse_map_directory(bytes, Bytes(32, 0x5B), *read).is(StatusCode::map_not_authentic));
  EXPECT_TRUE(parse_map_directory(test::bytes_of(*directory), key, *read).is(StatusCode::map_not_authentic))
      << "not signed";
  // The code is that of RFC 2104 over all that stands before it.
  const std::span<const std::uint8_t> signed_part(bytes.data(), bytes.size() - 32);
  const std::span<const std::uint8_t> parts[] = {signed_part};
  const HmacSha256 code = hmac_sha256(key, parts);
  EXPECT_TRUE(std::equal(code.begin(), code.end(), bytes.end() - 32));
  Bytes forged = bytes;
  forged[20] ^= 1;
  restore_checksum(forged);
  EXPECT_TRUE(parse_map_directory(forged, key, *read).is(StatusCode::map_not_authentic));
}

TEST(MapDirectory, EveryChangedOctetIsNoticed) {
  const Bytes bytes = test::bytes_of(*directory_with_tiles(), key);
  const auto read = std::make_unique<MapDirectory>();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    Bytes changed = bytes;
    changed[i] ^= 0x40;
    EXPECT_FALSE(parse_map_directory(changed, key, *read).ok()) << i;
    // Without a key, the code is not looked at.
    EXPECT_EQ(parse_map_directory(changed, {}, *read).ok(), i >= bytes.size() - 32) << i;
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(parse_map_directory(std::span(bytes).first(size), key, *read).ok()) << size;
  }
}

TEST(MapDirectory, WhatNoMapHasIsRefused) {
  const auto refused = [](auto change, bool written_too = true) {
    const auto directory = directory_with_tiles();
    change(*directory);
    Bytes bytes(max_map_directory_bytes);
    std::size_t size = 0;
    EXPECT_EQ(!write_map_directory(*directory, {}, bytes, size).ok(), written_too);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([&](MapDirectory& d) { d.longitude_rad = nan; });
  refused([](MapDirectory& d) { d.latitude_rad = 1.6; });
  refused([](MapDirectory& d) { d.sun_elevation_rad = -0.1; });
  refused([](MapDirectory& d) { d.layer_count = 0; });
  refused([](MapDirectory& d) { d.layer_count = 3; });
  refused([](MapDirectory& d) { d.layers[0].pixel_m = 0; });
  refused([](MapDirectory& d) { d.layers[1].pixel_m = d.layers[0].pixel_m; });
  refused([](MapDirectory& d) { d.layers[0].rows = 5000; });
  refused([](MapDirectory& d) { d.tiles[3].row = 17; });
  refused([](MapDirectory& d) { d.tiles[3] = d.tiles[2]; });
  refused([](MapDirectory& d) { std::swap(d.tiles[3], d.tiles[2]); });
  refused([](MapDirectory& d) { d.tiles[3].bytes = 0; });
  refused([](MapDirectory&) {}, false);
  // Titan is 8090 km from its one side to the other.
  const auto titan = [](double pixel_m) {
    return [pixel_m](MapDirectory& d) {
      d.body = Body::titan;
      d.layers[1].pixel_m = pixel_m;
      d.layers[1].columns = 8;
    };
  };
  refused(titan(4000), false);
  refused(titan(5000));
  refused([](MapDirectory& d) { d.layers[0].x0_m = -2e7; });
  refused([](MapDirectory& d) { d.layers[0].y0_m = 1.1e7; });
  refused([](MapDirectory& d) { d.layers[0].y0_m = 1e7; }, false);

  // The same in bytes whose checksum is right: number of tiles, body, light, version, magic.
  const Bytes bytes = test::bytes_of(*directory_with_tiles());
  const auto read = std::make_unique<MapDirectory>();
  const auto status_with = [&](std::size_t at, std::uint8_t value) {
    Bytes changed = bytes;
    changed[at] = value;
    restore_checksum(changed);
    return parse_map_directory(changed, {}, *read).code;
  };
  EXPECT_EQ(status_with(0, 'X'), StatusCode::parse_error);
  EXPECT_EQ(status_with(4, 2), StatusCode::unsupported_format);
  EXPECT_EQ(status_with(6, 99), StatusCode::parse_error);
  EXPECT_EQ(status_with(7, 99), StatusCode::parse_error);
  EXPECT_EQ(status_with(148, 255), StatusCode::parse_error);
  EXPECT_EQ(status_with(149, 255), StatusCode::parse_error);
  EXPECT_EQ(status_with(6, 1), StatusCode::ok);
}

TEST(MapDirectory, ATooSmallBufferIsTold) {
  Bytes bytes(100);
  std::size_t size = 0;
  EXPECT_TRUE(write_map_directory(*directory_with_tiles(), {}, bytes, size).is(StatusCode::capacity_exceeded));
  EXPECT_EQ(size, 0U);
}

}  // namespace
}  // namespace ilp
