// Moves strips into level frames by the vehicle's navigation.
#pragma once

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Applies the similarity of each strip's StripFrameRecord to its poses, points and depths, with their errors. After
/// that the strip's world has x to the east, y to the north and z up, as far as the record knows these directions, and
/// is in metres if the record knows the scale (ScaleSource::navigation). Strips without the record do not change. An
/// implausible record is removed, with a remark.
void level_strips(Flight& flight);

}  // namespace ilp::intake
