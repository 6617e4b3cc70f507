// A TIFF file of one band of 16 bits, uncompressed, written by libtiff.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace ilp::test {

/// `values` row by row. A file that cannot be written fails the test.
void write_tiff(const std::filesystem::path& path, int width, int height, const std::vector<std::uint16_t>& values);

}  // namespace ilp::test
