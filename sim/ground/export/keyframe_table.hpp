// What is known of keyframes, a row each: for keyframes.csv and as attributes of shapes.
#pragma once

#include "sim/ground/export/table.hpp"

namespace ilp::ground {

/// Times are seconds since the mission epoch, sigmas one standard deviation along the axes of the strip's world in
/// `unit_length` (map units per strip unit); cells of what has not come are empty.
[[nodiscard]] std::vector<Column> keyframe_columns();
[[nodiscard]] std::vector<Cell> keyframe_row(const Keyframe& keyframe, double unit_length);

/// keyframes.csv: all keyframes of the flight, with their poses in the strips' own axes and units.
[[nodiscard]] Table keyframe_table(const Flight& flight);

}  // namespace ilp::ground
