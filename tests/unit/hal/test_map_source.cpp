// A map's files in a folder and in memory.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/maps/directory_map_source.hpp"
#include "tests/support/memory_map_source.hpp"

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

TEST_F(MapFolder, TakesFilesWholeAndSaysThatItsDirectoryWasReplaced) {
  DirectoryMapSource source;
  ASSERT_TRUE(source.open((folder_ / "new").c_str()).ok());
  const std::uint64_t none = source.directory_mark();
  ASSERT_TRUE(source.write_directory(directory_file).ok()) << "the folder is made";
  ASSERT_TRUE(source.write_tile({1, 12, 4095}, tile_file).ok());
  expect_files(source);
  const std::uint64_t first = source.directory_mark();
  EXPECT_NE(first, none);
  EXPECT_EQ(source.directory_mark(), first);
  ASSERT_TRUE(source.write_directory(directory_file).ok());
  EXPECT_NE(source.directory_mark(), first);
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "new")) {
    ++files;
    EXPECT_NE(entry.path().extension(), ".part");
  }
  EXPECT_EQ(files, 2U);
  ASSERT_TRUE(source.erase_tile({1, 12, 4095}).ok());
  EXPECT_FALSE(fs::exists(folder_ / "new" / "tile-1-0012-4095.ilpt"));
  EXPECT_TRUE(source.erase_tile({1, 12, 4095}).ok()) << "there is none";
}

TEST_F(MapFolder, AFileThatCannotBeWrittenLeavesTheOneBefore) {
  DirectoryMapSource source;
  ASSERT_TRUE(source.open(folder_.c_str()).ok());
  ASSERT_TRUE(source.write_directory(directory_file).ok());
  fs::create_directories(folder_ / "directory.ilpm.part");
  EXPECT_TRUE(source.write_directory(tile_file).is(StatusCode::io_error));
  std::array<std::uint8_t, 8> bytes{};
  std::size_t size = 0;
  ASSERT_TRUE(source.read_directory(bytes, size).ok());
  EXPECT_EQ(size, directory_file.size());
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
