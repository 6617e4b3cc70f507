#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "sim/host/geo_raster.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

std::string message(const std::filesystem::path& path) {
  return test::error_of([&] { static_cast<void>(read_raster(path)); });
}

void set_shape(TIFF* tiff, std::uint32_t width, std::uint32_t height, int bands, int bits, int format) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, bands);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, bands == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
}

/// A little-endian TIFF of one row of `samples`, byte by byte from the standards' tables: no library has a say.
class PlainTiff {
 public:
  void number(std::uint16_t tag, std::uint16_t type, std::uint32_t value) {
    entries_.push_back({tag, type, 1, value, {}});
  }
  void doubles(std::uint16_t tag, const std::vector<double>& values) {
    entries_.push_back({tag, 12, static_cast<std::uint32_t>(values.size()), 0, bytes_of(values)});
  }
  void shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values) {
    entries_.push_back({tag, 3, static_cast<std::uint32_t>(values.size()), 0, bytes_of(values)});
  }
  void text(std::uint16_t tag, const std::string& value) {
    std::string bytes = value + '\0';
    entries_.push_back({tag, 2, static_cast<std::uint32_t>(bytes.size()), 0, bytes});
  }
  void write(const std::filesystem::path& path, const std::vector<std::int16_t>& samples) {
    const std::string pixels = bytes_of(samples);
    number(273, 4, 8);
    number(279, 4, static_cast<std::uint32_t>(pixels.size()));
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
    const auto directory = static_cast<std::uint32_t>(8 + pixels.size());
    auto behind = static_cast<std::uint32_t>(directory + 2 + 12 * entries_.size() + 4);
    std::string head = std::string("II*\0", 4) + bytes_of<std::uint32_t>({directory}) + pixels;
    head += bytes_of<std::uint16_t>({static_cast<std::uint16_t>(entries_.size())});
    std::string tail;
    for (const Entry& entry : entries_) {
      head += bytes_of<std::uint16_t>({entry.tag, entry.type}) + bytes_of<std::uint32_t>({entry.count});
      if (entry.data.size() > 4) {
        head += bytes_of<std::uint32_t>({behind});
        behind += static_cast<std::uint32_t>(entry.data.size());
        tail += entry.data;
      } else if (!entry.data.empty()) {
        head += entry.data + std::string(4 - entry.data.size(), '\0');
      } else {
        head += bytes_of<std::uint32_t>({entry.value});
      }
    }
    std::ofstream(path, std::ios::binary) << head << bytes_of<std::uint32_t>({0}) << tail;
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count, value;
    std::string data;
  };
  template <typename T>
  static std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
  }
  std::vector<Entry> entries_;
};

/// 3x2 heights in 16-bit integers at 25 m, pixels' corner at (1000, 5000).
PlainTiff mars_dtm() {
  PlainTiff tiff;
  tiff.number(256, 3, 3);
  tiff.number(257, 3, 2);
  tiff.number(258, 3, 16);
  tiff.number(259, 3, 1);
  tiff.number(262, 3, 1);
  tiff.number(277, 3, 1);
  tiff.number(278, 3, 2);
  tiff.number(339, 3, 2);
  tiff.doubles(33550, {25, 25, 0});
  tiff.doubles(33922, {0, 0, 0, 1000, 5000, 0});
  tiff.text(42113, "-32768");
  return tiff;
}

TEST(GeoTiff, ReadsAFileWrittenFromTheStandard) {
  const test::ScratchFolder folder;
  mars_dtm().write(folder / "dtm.tif", {-4200, -4199, -32768, 7, 8, 9});
  const GeoRaster raster = read_raster(folder / "dtm.tif");
  ASSERT_EQ(raster.values.width, 3);
  ASSERT_EQ(raster.values.height, 2);
  EXPECT_EQ(raster.values.at(0, 0), -4200);
  EXPECT_EQ(raster.values.at(1, 0), -4199);
  EXPECT_TRUE(std::isnan(raster.values.at(2, 0)));
  EXPECT_EQ(raster.values.at(2, 1), 9);
  ASSERT_TRUE(raster.place.has_value());
  EXPECT_EQ(raster.place->spacing_x, 25);
  EXPECT_EQ(raster.place->x, 1012.5);  // centre of the pixel whose corner is tied
  EXPECT_EQ(raster.place->y, 4987.5);
}

TEST(GeoTiff, TiePointOfAPointRasterIsThePixelsCentre) {
  const test::ScratchFolder folder;
  PlainTiff tiff = mars_dtm();
  tiff.shorts(34735, {1, 1, 0, 2, 1024, 0, 1, 1, 1025, 0, 1, 2});
  tiff.write(folder / "dtm.tif", {1, 2, 3, 4, 5, 6});
  const GeoRaster raster = read_raster(folder / "dtm.tif");
  EXPECT_EQ(raster.place->x, 1000);
  EXPECT_EQ(raster.place->y, 5000);
}

TEST(GeoTiff, DegreesAreRefused) {
  const test::ScratchFolder folder;
  PlainTiff tiff = mars_dtm();
  tiff.shorts(34735, {1, 1, 0, 1, 1024, 0, 1, 2});
  tiff.write(folder / "dtm.tif", {1, 2, 3, 4, 5, 6});
  EXPECT_NE(message(folder / "dtm.tif").find("degrees"), std::string::npos);
}

TEST(GeoTiff, HeightsComeBackWithTheirPlace) {
  const test::ScratchFolder folder;
  Raster<float> heights(700, 300);
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 700; ++x) heights.at(x, y) = 0.1F * static_cast<float>(x) - 3.7F * static_cast<float>(y);
  }
  heights.at(5, 6) = nan;
  const RasterPlace place{-12.25, 80.5, 0.25, 0.5};
  write_geotiff(folder / "h.tif", heights.view(), place);
  const GeoRaster back = read_raster(folder / "h.tif");
  ASSERT_EQ(back.values.width, 700);
  ASSERT_EQ(back.values.height, 300);
  for (std::size_t k = 0; k < heights.samples.size(); ++k) {
    if (std::isnan(heights.samples[k])) {
      ASSERT_TRUE(std::isnan(back.values.samples[k]));
    } else {
      ASSERT_EQ(heights.samples[k], back.values.samples[k]);
    }
  }
  ASSERT_TRUE(back.place.has_value());
  EXPECT_DOUBLE_EQ(back.place->x, place.x);
  EXPECT_DOUBLE_EQ(back.place->y, place.y);
  EXPECT_EQ(back.place->spacing_x, place.spacing_x);
  EXPECT_EQ(back.place->spacing_y, place.spacing_y);
}

// UTM zone 33, which GDAL looks up in the database of PROJ.
TEST(GeoTiff, MetresOfAKnownProjectionAreRead) {
  const test::ScratchFolder folder;
  PlainTiff tiff = mars_dtm();
  tiff.shorts(34735, {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633});
  tiff.write(folder / "dtm.tif", {1, 2, 3, 4, 5, 6});
  const GeoRaster raster = read_raster(folder / "dtm.tif");
  EXPECT_EQ(raster.place->x, 1012.5);
  EXPECT_EQ(raster.values.at(2, 1), 6);
}

// Tiles overlap the image's right and lower border.
TEST(GeoTiff, TiledRasterIsAssembled) {
  const test::ScratchFolder folder;
  constexpr std::uint32_t width = 75;
  constexpr std::uint32_t height = 53;
  constexpr std::uint32_t side = 32;
  TIFF* const tiff = TIFFOpen((folder / "t.tif").c_str(), "w");
  set_shape(tiff, width, height, 1, 16, SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_TILEWIDTH, side);
  TIFFSetField(tiff, TIFFTAG_TILELENGTH, side);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  for (std::uint32_t y0 = 0; y0 < height; y0 += side) {
    for (std::uint32_t x0 = 0; x0 < width; x0 += side) {
      std::vector<std::uint16_t> tile;
      for (std::uint32_t y = y0; y < y0 + side; ++y) {
        for (std::uint32_t x = x0; x < x0 + side; ++x) tile.push_back(static_cast<std::uint16_t>(1000 * y + x));
      }
      TIFFWriteTile(tiff, tile.data(), x0, y0, 0, 0);
    }
  }
  TIFFClose(tiff);
  const GeoRaster raster = read_raster(folder / "t.tif");
  EXPECT_FALSE(raster.place.has_value());
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      ASSERT_EQ(raster.values.at(static_cast<int>(x), static_cast<int>(y)), static_cast<float>(1000 * y + x));
    }
  }
}

TEST(GeoTiff, WrongFilesAreRefusedWithAReason) {
  const test::ScratchFolder folder;
  TIFF* const colour = TIFFOpen((folder / "colour.tif").c_str(), "w");
  set_shape(colour, 4, 1, 3, 8, SAMPLEFORMAT_UINT);
  std::vector<std::uint8_t> row(12, 9);
  TIFFWriteScanline(colour, row.data(), 0);
  TIFFClose(colour);
  EXPECT_NE(message(folder / "colour.tif").find("3 bands, one expected"), std::string::npos);

  folder.write("text.tif", "heights: 1 2 3\n");
  EXPECT_NE(message(folder / "text.tif").find("text.tif: not a TIFF"), std::string::npos);
  EXPECT_NE(message(folder / "nothing.tif").find("nothing.tif"), std::string::npos);
  EXPECT_NE(message(folder.path()).find("not a TIFF"), std::string::npos);

  PlainTiff many = mars_dtm();
  many.number(322, 3, 0);
  many.write(folder / "odd.tif", {1, 2, 3, 4, 5, 6});
  EXPECT_NE(message(folder / "odd.tif"), "");
}

TEST(GeoTiff, CutFilesAreRefusedAtEveryLength) {
  const test::ScratchFolder folder;
  Raster<float> heights(64, 64, 1.5F);
  write_geotiff(folder / "whole.tif", heights.view(), {});
  const std::string bytes = test::text_of(folder / "whole.tif");
  for (std::size_t length = 0; length + 1 < bytes.size(); length += 7) {
    folder.write("cut.tif", bytes.substr(0, length));
    ASSERT_NE(message(folder / "cut.tif"), "") << length << " of " << bytes.size() << " bytes were read";
  }
}

}  // namespace
}  // namespace ilp::host
