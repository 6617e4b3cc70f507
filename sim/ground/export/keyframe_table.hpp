// One row per keyframe, for keyframes.csv and for the attributes of shapes.
#pragma once

#include "sim/ground/export/table.hpp"

namespace ilp::exports {

/// Times are seconds since the mission epoch, sigmas one standard deviation along the axes of the strip's world in
/// `unit_length` (map units per strip unit); cells without data are empty.
[[nodiscard]] std::vector<Column> keyframe_columns();
[[nodiscard]] std::vector<Cell> keyframe_row(const intake::Keyframe& keyframe, double unit_length);

/// keyframes.csv: all keyframes of the flight, with their poses in the strips' own axes and units.
[[nodiscard]] Table keyframe_table(const intake::Flight& flight);

}  // namespace ilp::exports
