// ChArUco boards: chessboards with markers in their white squares, of which a part may be seen, by OpenCV where this
// build has it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/tools/lab/target_calibration.hpp"

namespace ilp::lab {

/// Names of OpenCV's dictionaries of markers without DICT_, such as 5X5_100; empty in a build without it.
[[nodiscard]] std::vector<std::string> marker_dictionaries();

/// Corners of the part of the board that is seen, at least six in several rows and columns; `marker_share` is the side
/// of a marker over that of a square. Nothing where too few markers are seen. Throws std::runtime_error that says what
/// to do, where markers are seen that this board does not have or has elsewhere, and in a build without ArUco.
[[nodiscard]] std::optional<BoardCorners> find_charuco(const host::Raster<std::uint8_t>& picture, const Board& board,
                                                       const std::string& dictionary, double marker_share);

/// The dictionary of which most markers are seen, the smallest of those that share them; empty below four markers.
[[nodiscard]] std::string dictionary_in(const host::Raster<std::uint8_t>& picture);

}  // namespace ilp::lab
