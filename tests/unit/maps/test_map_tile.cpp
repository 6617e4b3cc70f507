// Tiles as files: heights and holes are exact, the image is near, damage is told.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/maps/plane_coding.hpp"
#include "fsw/vision/place/descriptor_distance.hpp"
#include "tests/unit/maps/known_map.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;
using test::enter_tile;
using test::known_directory;
using test::known_tile;

MapTileFeatures some_features() {
  MapTileFeatures features;
  Rng rng(3);
  for (int i = 0; i < 40; ++i) {
    PlaceFeature feature;
    feature.x = static_cast<float>(rng.uniform() * 255);
    feature.y = static_cast<float>(i) - 0.5F;
    feature.level = static_cast<std::uint8_t>(i % place_levels);
    feature.angle = static_cast<std::uint8_t>(i * 6);
    for (std::uint32_t& word : feature.descriptor) word = static_cast<std::uint32_t>(rng.below(1U << 31U));
    EXPECT_TRUE((i % 3 == 0 ? features.shape : features.image).push_back(feature));
  }
  return features;
}

struct Decoded {
  std::unique_ptr<MapTile> tile = std::make_unique<MapTile>();
  Status status;
};
Decoded decode(const Bytes& file, const MapDirectory& directory) {
  const auto workspace = std::make_unique<MapTileWorkspace>();
  Decoded decoded;
  decoded.status = decode_map_tile(file, directory, 0, *workspace, *decoded.tile);
  return decoded;
}

double psnr(const MapTile& a, const MapTile& b) {
  double sum = 0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < map_tile_pixels; ++i) {
    if (a.image[i] == 0) continue;
    const double difference = static_cast<double>(a.image[i]) - static_cast<double>(b.image[i]);
    sum += difference * difference;
    ++known;
  }
  return sum == 0 ? 99 : 10 * std::log10(255.0 * 255.0 * static_cast<double>(known) / sum);
}

TEST(MapTile, HeightsAndHolesAreExactAndTheImageIsNear) {
  const auto tile = known_tile();
  for (const std::size_t image_bytes : {std::size_t{1024}, std::size_t{4096}, std::size_t{16384}}) {
    auto directory = known_directory();
    const Bytes file = enter_tile(*tile, {}, image_bytes, *directory);
    ASSERT_FALSE(file.empty());
    const auto [decoded, status] = decode(file, *directory);
    ASSERT_TRUE(status.ok());
    EXPECT_EQ(decoded->row, 2);
    EXPECT_EQ(decoded->column, 3);
    EXPECT_EQ(decoded->posts, tile->posts);
    for (std::size_t i = 0; i < map_tile_pixels; ++i) EXPECT_EQ(decoded->image[i] == 0, tile->image[i] == 0) << i;
    EXPECT_GT(psnr(*tile, *decoded), image_bytes == 1024 ? 28 : image_bytes == 4096 ? 40 : 48);
    EXPECT_LT(file.size(), image_bytes + 7000);
  }
}

TEST(MapTile, PostsStandWhereTheHeaderSays) {
  const auto tile = known_tile();
  EXPECT_FALSE(tile->is_known(3, 4));
  EXPECT_TRUE(tile->is_known(30, 4));
  EXPECT_NEAR(tile->height_m(30, 4), -4400 + 0.05 * tile->posts[4 * 65 + 30], 1e-9);
}

TEST(MapTile, ATileThatKnowsOnlyHeightsOrOnlyAnImage) {
  auto tile = known_tile();
  tile->image.fill(0);
  auto directory = known_directory();
  Bytes file = enter_tile(*tile, {}, 4096, *directory);
  Decoded decoded = decode(file, *directory);
  ASSERT_TRUE(decoded.status.ok());
  EXPECT_EQ(decoded.tile->image, tile->image);
  EXPECT_EQ(decoded.tile->posts, tile->posts);

  tile = known_tile();
  tile->posts.fill(unknown_post);
  directory = known_directory();
  file = enter_tile(*tile, {}, 4096, *directory);
  decoded = decode(file, *directory);
  ASSERT_TRUE(decoded.status.ok());
  EXPECT_EQ(decoded.tile->posts, tile->posts);
}

TEST(MapTile, TheLargestHeightsComeBack) {
  auto tile = known_tile();
  Rng rng(5);
  for (std::int16_t& post : tile->posts) post = static_cast<std::int16_t>(static_cast<int>(rng.below(65535)) - 32767);
  auto directory = known_directory();
  const Bytes file = enter_tile(*tile, {}, 4096, *directory);
  const Decoded decoded = decode(file, *directory);
  ASSERT_TRUE(decoded.status.ok());
  EXPECT_EQ(decoded.tile->posts, tile->posts);
}

TEST(MapTile, FeaturesComeBackToAHundredthOfAPixel) {
  const MapTileFeatures features = some_features();
  auto directory = known_directory();
  const Bytes file = enter_tile(*known_tile(), features, 4096, *directory);
  MapTileFeatures read;
  ASSERT_TRUE(read_map_features(file, *directory, 0, read).ok());
  const auto expect_same = [](const MapFeatures& a, const MapFeatures& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_NEAR(a[i].x, b[i].x, 0.01F);
      EXPECT_NEAR(a[i].y, b[i].y, 0.01F);
      EXPECT_EQ(a[i].level, b[i].level);
      EXPECT_EQ(a[i].angle, b[i].angle);
      EXPECT_EQ(hamming_256(a[i].descriptor, b[i].descriptor), 0);
    }
  };
  expect_same(features.image, read.image);
  expect_same(features.shape, read.shape);
}

TEST(MapTile, AFeatureOutsideTheTileIsNotWritten) {
  MapTileFeatures features;
  PlaceFeature outside{.x = 256};
  ASSERT_TRUE(features.image.push_back(outside));
  const auto workspace = std::make_unique<MapTileWorkspace>();
  Bytes file(limits::max_map_tile_bytes);
  std::size_t size = 0;
  EXPECT_TRUE(encode_map_tile(*known_tile(), features, 1, {}, *workspace, file, size).is(StatusCode::invalid_argument));
}

TEST(MapTile, EveryChangedOctetIsNoticed) {
  auto directory = known_directory();
  const Bytes file = enter_tile(*known_tile(), some_features(), 1024, *directory);
  for (std::size_t i = 0; i < file.size(); i += 7) {
    Bytes changed = file;
    changed[i] ^= 1;
    EXPECT_TRUE(decode(changed, *directory).status.is(StatusCode::record_damaged)) << i;
  }
  Bytes shorter = file;
  shorter.pop_back();
  EXPECT_TRUE(decode(shorter, *directory).status.is(StatusCode::record_damaged));
}

/// Enters the bytes as they are: the digest is right, so that the tile itself is looked at.
Status status_of(const Bytes& file, MapDirectory& directory) {
  directory.tiles[0].digest = map_tile_digest(directory.id, file);
  directory.tiles[0].bytes = static_cast<std::uint16_t>(file.size());
  MapTileFeatures features;
  const Decoded decoded = decode(file, directory);
  if (!decoded.status.ok()) return decoded.status;
  return read_map_features(file, directory, 0, features);
}

TEST(MapTile, AnotherMapsTileOrPlaceIsRefused) {
  auto directory = known_directory();
  const Bytes file = enter_tile(*known_tile(), {}, 1024, *directory);
  EXPECT_TRUE(status_of(file, *directory).ok());
  Bytes changed = file;
  set_map_id(changed, directory->id + 1);
  EXPECT_TRUE(status_of(changed, *directory).is(StatusCode::parse_error));
  set_map_id(changed, directory->id);
  EXPECT_EQ(changed, file);
  directory->tiles[0].column = 4;
  EXPECT_TRUE(status_of(file, *directory).is(StatusCode::parse_error));
}

TEST(MapTile, HostileBytesWithARightDigestAreRefusedOrDecoded) {
  auto directory = known_directory();
  const Bytes file = enter_tile(*known_tile(), some_features(), 512, *directory);
  Rng rng(11);
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Bytes changed = file;
    for (std::uint32_t k = 1 + rng.below(4); k > 0; --k) {
      // Half of them in the head, where the lengths are.
      const std::size_t at = rng.below(trial % 2 == 0 ? 52 : static_cast<std::uint32_t>(changed.size()));
      changed[at] = static_cast<std::uint8_t>(rng.below(256));
    }
    if (trial % 5 == 0) {
      changed.erase(changed.end() - static_cast<std::ptrdiff_t>(rng.below(static_cast<std::uint32_t>(changed.size()))),
                    changed.end());
    }
    refused += status_of(changed, *directory).ok() ? 0 : 1;
  }
  EXPECT_GT(refused, 200);
  EXPECT_TRUE(status_of({}, *directory).is(StatusCode::truncated));
}

TEST(MapTile, AnyPlaneComesBackWithoutLoss) {
  Rng rng(7);
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 3}, {65, 65}, {33, 7}, {256, 256}}) {
    const auto count = static_cast<std::size_t>(width * height);
    for (const std::uint32_t range : {1U, 2U, 300U, 131072U}) {
      std::vector<std::int32_t> plane(count), scratch(count);
      for (std::int32_t& sample : plane) {
        sample = static_cast<std::int32_t>(rng.below(range)) - static_cast<std::int32_t>(range / 2);
      }
      const std::vector<std::int32_t> original = plane;
      Bytes bytes(count * 5 + 64);
      const std::size_t size = encode_plane({plane.data(), width, height}, lossless_step, scratch.data(), bytes);
      ASSERT_LE(size, bytes.size());
      bytes.resize(size);
      std::fill(plane.begin(), plane.end(), -5);
      ASSERT_TRUE(decode_plane(bytes, lossless_step, scratch.data(), {plane.data(), width, height}).ok())
          << width << " " << range;
      EXPECT_EQ(plane, original) << width << "x" << height << " " << range;
      bytes.push_back(0);
      EXPECT_FALSE(decode_plane(bytes, lossless_step, scratch.data(), {plane.data(), width, height}).ok());
    }
  }
}

}  // namespace
}  // namespace ilp
