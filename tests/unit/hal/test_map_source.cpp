// A map's files in a folder and in memory.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/maps/directory_map_source.hpp"
#include "hal/maps/memory_map_source.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

class MapFolder : public ::testing::Test {
 protected:
  MapFolder() : folder_(fs::temp_directory_path() / ("ilp-map-source-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~MapFolder() override { fs::remove_all(folder_); }
  void put(const std::string& name, const Bytes& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

  fs::path folder_;
};

void expect_files(MapSource& source) {
  std::array<std::uint8_t, 8> bytes{};
  std::size_t size = 0;
  ASSERT_TRUE(source.read_directory(bytes, size).ok());
  ASSERT_EQ(size, 3U);
  EXPECT_EQ(bytes[2], 9);
  ASSERT_TRUE(source.read_tile({1, 12, 4095}, bytes, size).ok());
  ASSERT_EQ(size, 8U);
  EXPECT_EQ(bytes[7], 7);
  EXPECT_TRUE(source.read_tile({1, 12, 4094}, bytes, size).is(StatusCode::not_found));
  EXPECT_EQ(size, 0U);
  const Status too_large = source.read_tile({1, 12, 4095}, std::span(bytes).first(7), size);
  EXPECT_TRUE(too_large.is(StatusCode::capacity_exceeded));
  EXPECT_EQ(too_large.a, 8);
  EXPECT_EQ(size, 0U);
}

const Bytes directory_file = {1, 5, 9}, tile_file = {0, 1, 2, 3, 4, 5, 6, 7};

TEST_F(MapFolder, HasTheNamedFiles) {
  put("directory.ilpm", directory_file);
  put("tile-1-0012-4095.ilpt", tile_file);
  DirectoryMapSource source;
  ASSERT_TRUE(source.open(folder_.c_str()).ok());
  EXPECT_TRUE(source.has_directory());
  expect_files(source);
}

TEST_F(MapFolder, ThatIsEmptyMissingOrNamedTooLong) {
  std::array<std::uint8_t, 8> bytes{};
  std::size_t size = 0;
  DirectoryMapSource source;
  EXPECT_TRUE(source.read_directory(bytes, size).is(StatusCode::not_found)) << "not open";
  EXPECT_FALSE(source.has_directory());
  ASSERT_TRUE(source.open(folder_.c_str()).ok());
  EXPECT_TRUE(source.read_directory(bytes, size).is(StatusCode::not_found));
  EXPECT_FALSE(source.has_directory());
  ASSERT_TRUE(source.open((folder_ / "none").c_str()).ok());
  EXPECT_FALSE(source.has_directory());
  EXPECT_TRUE(source.read_directory(bytes, size).is(StatusCode::not_found));
  EXPECT_TRUE(source.open(std::string(limits::max_path_bytes - 10, 'x').c_str()).is(StatusCode::capacity_exceeded));
}

TEST_F(MapFolder, APipeOrAFolderIsNoFile) {
  std::array<std::uint8_t, 8> bytes{};
  std::size_t size = 0;
  ASSERT_EQ(::mkfifo((folder_ / "directory.ilpm").c_str(), 0600), 0);
  fs::create_directories(folder_ / "tile-0-0000-0000.ilpt");
  DirectoryMapSource source;
  ASSERT_TRUE(source.open(folder_.c_str()).ok());
  EXPECT_TRUE(source.read_directory(bytes, size).is(StatusCode::io_error));
  EXPECT_TRUE(source.read_tile({0, 0, 0}, bytes, size).is(StatusCode::io_error));
}

TEST(MemoryMap, HasTheSameFiles) {
  const MemoryMapSource::Tile tiles[] = {{{0, 0, 0}, directory_file}, {{1, 12, 4095}, tile_file}};
  MemoryMapSource source(directory_file, tiles);
  expect_files(source);
  MemoryMapSource none;
  std::array<std::uint8_t, 8> bytes{};
  std::size_t size = 0;
  EXPECT_TRUE(none.read_directory(bytes, size).is(StatusCode::not_found));
}

}  // namespace
}  // namespace ilp
