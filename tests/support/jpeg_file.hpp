// JPEG files for tests, written by libjpeg.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace ilp::test {

struct JpegKind {
  int quality = 100;
  bool colour = true;
  int horizontal = 2, vertical = 2;  ///< samples of luma for each one of colour
  int restart_rows = 0;              ///< rows of blocks between restarts; 0 for none
  bool progressive = false;
  bool arithmetic = false;
  bool one_scan_per_component = false;
  bool standard_tables_left_out = false;  ///< as many cameras do
};

using Luma = std::function<std::uint8_t(std::int32_t x, std::int32_t y)>;

/// A file of the picture; its colour is some pattern.
std::vector<std::uint8_t> jpeg_file(std::int32_t width, std::int32_t height, const Luma& luma,
                                    const JpegKind& kind = {});

}  // namespace ilp::test
