// Strips whose place the vehicle has measured become metric, level and turned to north.
#pragma once

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Applies the similarity of each strip's StripFrameRecord to its poses, points and depths, with their errors. The
/// world of such a strip has x to the east, y to the north and z up, as far as they are known, and is in metres if the
/// scale is known (ScaleSource::navigation). Strips without the record stay as they are.
void level_strips(Flight& flight);

}  // namespace ilp::intake
