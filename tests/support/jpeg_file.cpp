#include "tests/support/jpeg_file.hpp"

#include <cstddef>
#include <cstdio>
#include <cstdlib>
// The first ones must be read first.
#include <jpeglib.h>

namespace ilp::test {
namespace {

constexpr jpeg_scan_info one_by_one[] = {{1, {0}, 0, 63, 0, 0}, {1, {1}, 0, 63, 0, 0}, {1, {2}, 0, 63, 0, 0}};

void choose(jpeg_compress_struct& encoder, const JpegKind& kind) {
  encoder.input_components = kind.colour ? 3 : 1;
  encoder.in_color_space = kind.colour ? JCS_YCbCr : JCS_GRAYSCALE;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, kind.quality, TRUE);
  encoder.dct_method = JDCT_ISLOW;
  if (kind.colour) {
    encoder.comp_info[0].h_samp_factor = kind.horizontal;
    encoder.comp_info[0].v_samp_factor = kind.vertical;
  }
  encoder.restart_in_rows = kind.restart_rows;
  encoder.arith_code = kind.arithmetic ? TRUE : FALSE;
  if (kind.progressive) jpeg_simple_progression(&encoder);
  if (kind.one_scan_per_component) {
    encoder.scan_info = one_by_one;
    encoder.num_scans = 3;
  }
}

/// Removes the segments FFC4, which stand before the data of the scan.
void leave_out_tables(std::vector<std::uint8_t>& file) {
  for (std::size_t at = 2; at + 4 < file.size() && file[at] == 0xFF && file[at + 1] != 0xDA;) {
    const std::size_t length = 2 + (std::size_t{file[at + 2]} << 8U | file[at + 3]);
    const auto begin = file.begin() + static_cast<std::ptrdiff_t>(at);
    if (file[at + 1] == 0xC4) {
      file.erase(begin, begin + static_cast<std::ptrdiff_t>(length));
    } else {
      at += length;
    }
  }
}

}  // namespace

std::vector<std::uint8_t> jpeg_file(std::int32_t width, std::int32_t height, const Luma& luma, const JpegKind& kind) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &bytes, &size);
  encoder.image_width = static_cast<JDIMENSION>(width);
  encoder.image_height = static_cast<JDIMENSION>(height);
  choose(encoder, kind);
  jpeg_start_compress(&encoder, TRUE);
  std::vector<std::uint8_t> row;
  for (std::int32_t y = 0; y < height; ++y) {
    row.clear();
    for (std::int32_t x = 0; x < width; ++x) {
      row.push_back(luma(x, y));
      if (!kind.colour) continue;
      row.push_back(static_cast<std::uint8_t>(100 + x % 50));
      row.push_back(static_cast<std::uint8_t>(160 - y % 50));
    }
    JSAMPROW pixels = row.data();
    jpeg_write_scanlines(&encoder, &pixels, 1);
  }
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  std::vector<std::uint8_t> file(bytes, bytes + size);
  std::free(bytes);
  if (kind.standard_tables_left_out) leave_out_tables(file);
  return file;
}

}  // namespace ilp::test
