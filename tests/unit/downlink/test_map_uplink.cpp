// Files of a map from the ground, through FileDelivery and the link, into a folder.
#include "fsw/downlink/map_uplink.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "hal/maps/directory_map_source.hpp"
#include "tests/unit/downlink/uplink_fixture.hpp"
#include "tests/unit/maps/known_map.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

using test::Bytes;
using test::bytes_of;
using State = ground_cfdp::CfdpSender::State;

constexpr const char* tile_name = "tile-0-0002-0003.ilpt";

class MapUplink : public test::UplinkTest {
 protected:
  MapUplink() : folder_(fs::temp_directory_path() / ("ilp-map-uplink-" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    EXPECT_TRUE(source_.open(folder_.c_str()).ok());
    rig.mission.body = Body::mars;
    rig.map = &source_;
    rig.reboot();
  }
  ~MapUplink() override { fs::remove_all(folder_); }

  Bytes on_board(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  /// The newest refusal.
  StatusCode refused() const {
    for (auto event = rig.events.rbegin(); event != rig.events.rend(); ++event)
      if (event->is(StatusCode::map_file_refused)) return static_cast<StatusCode>(event->a);
    return StatusCode::ok;
  }

  fs::path folder_;
  DirectoryMapSource source_;
  std::unique_ptr<MapDirectory> directory_ = test::known_directory();
  Bytes tile_ = test::enter_tile(*test::known_tile(), {}, 4096, *directory_);
};

TEST_F(MapUplink, ADirectoryAndThenItsTilesLieInTheFolderAsTheyWereSent) {
  const Bytes directory = bytes_of(*directory_);
  EXPECT_EQ(put("directory.ilpm", directory).state, State::retained);
  EXPECT_TRUE(rig.saw(StatusCode::map_received));
  EXPECT_EQ(put(tile_name, tile_).state, State::retained);
  EXPECT_EQ(on_board("directory.ilpm"), directory);
  EXPECT_EQ(on_board(tile_name), tile_);
  EXPECT_EQ(refused(), StatusCode::ok);
  std::int64_t records = -1;
  EXPECT_TRUE(rig.store.count(record_info<UplinkRecord>(), records).ok());
  EXPECT_EQ(records, 0) << "a map pushes no file of parameters out";
}

TEST_F(MapUplink, ATileGoesWhereTheDirectoryHasItWhateverItsNameSays) {
  ASSERT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::retained);
  EXPECT_EQ(put("tile-1-0000-0000.ilpt", tile_).state, State::retained);
  EXPECT_EQ(on_board(tile_name), tile_);
  EXPECT_FALSE(fs::exists(folder_ / "tile-1-0000-0000.ilpt"));
}

TEST_F(MapUplink, ADamagedOrForgedTileReplacesNone) {
  EXPECT_EQ(put(tile_name, tile_).state, State::failed);
  EXPECT_EQ(refused(), StatusCode::not_found) << "its directory comes first";
  ASSERT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::retained);
  ASSERT_EQ(put(tile_name, tile_).state, State::retained);
  for (const std::size_t at : {std::size_t{0}, tile_.size() / 2, tile_.size() - 1}) {
    Bytes other = tile_;
    other[at] ^= 1U;
    EXPECT_EQ(put(tile_name, other).state, State::failed);
    EXPECT_EQ(refused(), StatusCode::record_damaged);
  }
  EXPECT_EQ(on_board(tile_name), tile_);
}

TEST_F(MapUplink, ADirectoryThatTheFlightCannotUseReplacesNone) {
  const Bytes good = bytes_of(*directory_);
  ASSERT_EQ(put("directory.ilpm", good).state, State::retained);
  directory_->body = Body::moon;
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::failed);
  EXPECT_EQ(refused(), StatusCode::map_other_body);
  directory_->body = Body::mars;
  Bytes damaged = good;
  damaged[40] ^= 4U;
  EXPECT_EQ(put("directory.ilpm", damaged).state, State::failed);
  EXPECT_EQ(refused(), StatusCode::parse_error);
  EXPECT_EQ(on_board("directory.ilpm"), good);
}

TEST_F(MapUplink, WithAKeyOnlyADirectorySignedWithItIsTaken) {
  const Bytes key(32, 0x5A), other(32, 0x5B);
  source_.require_key(key);
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::failed);
  EXPECT_EQ(refused(), StatusCode::map_not_authentic);
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_, other)).state, State::failed);
  EXPECT_FALSE(source_.has_directory());
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_, key)).state, State::retained);
  EXPECT_EQ(put(tile_name, tile_).state, State::retained);
}

TEST_F(MapUplink, AMapTakesAtMostItsShareOfTheBudget) {
  rig.mission.storage_budget_mib = 1;
  const auto add = [&](std::uint16_t row, std::uint16_t column) {
    MapTileEntry entry{row * 100U + column, 65535, 0, row, column};
    ASSERT_TRUE(directory_->tiles.push_back(entry));
  };
  for (std::uint16_t column = 0; column < 3; ++column) add(3, column);
  // Three tiles of 65535 bytes and one of some 8000, of 256 KiB.
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::retained);
  add(3, 3);
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::failed);
  EXPECT_EQ(refused(), StatusCode::capacity_exceeded);
}

TEST_F(MapUplink, TheTilesOfAnotherMapGoAndThoseOfTheSameStay) {
  ASSERT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::retained);
  ASSERT_EQ(put(tile_name, tile_).state, State::retained);
  directory_->image_sigma = 3;
  ASSERT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::retained);
  EXPECT_EQ(on_board(tile_name), tile_);
  directory_->id += 1;
  ASSERT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::retained);
  EXPECT_FALSE(fs::exists(folder_ / tile_name));
}

TEST_F(MapUplink, WithoutAFolderAFileOfAMapIsRefused) {
  rig.map = nullptr;
  rig.reboot();
  EXPECT_EQ(put("directory.ilpm", bytes_of(*directory_)).state, State::failed);
  EXPECT_EQ(refused(), StatusCode::not_found);
}

}  // namespace
}  // namespace ilp
