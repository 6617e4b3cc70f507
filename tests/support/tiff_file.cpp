#include "tests/support/tiff_file.hpp"

#include <gtest/gtest.h>
#include <tiffio.h>

namespace ilp::test {

void write_tiff(const std::filesystem::path& path, int width, int height, const std::vector<std::uint16_t>& values) {
  TIFF* const tiff = TIFFOpen(path.c_str(), "w");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  for (int y = 0; y < height; ++y) {
    std::vector<std::uint16_t> row(values.begin() + y * width, values.begin() + (y + 1) * width);
    TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0);
  }
  TIFFClose(tiff);
}

}  // namespace ilp::test
