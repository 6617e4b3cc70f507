// Detects ChArUco boards (chessboards with markers in the white squares), which may be partly visible. Needs a build
// with OpenCV's ArUco.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/tools/lab/target_calibration.hpp"

namespace ilp::lab {

/// Names of OpenCV's marker dictionaries without the prefix DICT_, such as 5X5_100; empty in a build without ArUco.
[[nodiscard]] std::vector<std::string> marker_dictionaries();

/// Finds the visible corners of the board. `marker_share` is the ratio of the marker's side to the square's side. Empty
/// unless at least six corners in two or more rows and columns are found. Throws std::runtime_error with advice if
/// markers are seen that the board does not have or has at other positions, and in a build without ArUco.
[[nodiscard]] std::optional<BoardCorners> find_charuco(const host::Raster<std::uint8_t>& picture, const Board& board,
                                                       const std::string& dictionary, double marker_share);

/// Finds the dictionary with most markers in the picture; of dictionaries with the same markers, the smallest. Empty
/// for fewer than four markers.
[[nodiscard]] std::string dictionary_in(const host::Raster<std::uint8_t>& picture);

}  // namespace ilp::lab
