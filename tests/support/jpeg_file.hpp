// Makes JPEG files of all kinds with libjpeg.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace ilp::test {

struct JpegKind {
  int quality = 100;
  bool colour = true;
  int horizontal = 2, vertical = 2;  ///< ratio of luma samples to chroma samples
  int restart_rows = 0;              ///< rows of blocks between restart markers; 0: no markers
  bool progressive = false;
  bool arithmetic = false;
  bool one_scan_per_component = false;
  bool standard_tables_left_out = false;  ///< without the standard Huffman tables, as many cameras write
};

/// Luma of pixel (x, y).
using Luma = std::function<std::uint8_t(std::int32_t x, std::int32_t y)>;

/// Returns a file of a picture with this luma; its chroma is an arbitrary pattern.
std::vector<std::uint8_t> jpeg_file(std::int32_t width, std::int32_t height, const Luma& luma,
                                    const JpegKind& kind = {});

}  // namespace ilp::test
