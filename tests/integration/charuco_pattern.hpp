// A ChArUco board as OpenCV prints it, where this build has OpenCV's ArUco.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim/host/raster.hpp"

namespace ilp::test {

/// Board of columns x rows inner corners without a margin; each square has `px` pixels each way, a marker three
/// quarters of that. Dictionaries: 5X5_100 and 4X4_50.
[[nodiscard]] std::optional<host::Raster<std::uint8_t>> charuco_pattern(int columns, int rows,
                                                                        const std::string& dictionary, int px);

}  // namespace ilp::test
