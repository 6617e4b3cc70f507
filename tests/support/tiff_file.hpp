// Writes an uncompressed TIFF file with one band of 16 bits by libtiff.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace ilp::test {

/// Writes `values` in row-major order. The test fails if the file cannot be written.
void write_tiff(const std::filesystem::path& path, int width, int height, const std::vector<std::uint16_t>& values);

}  // namespace ilp::test
