// Links and ties that came down, whose records may hold anything.
#pragma once

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Leaves out each link and tie that no flight makes, and names it with the reason in the remarks: one that does not
/// lead to an earlier keyframe or strip, has a number that is not its keyframe's, another strip than its keyframes, an
/// unknown verdict, more points than a link has, or a value that is no number. What is left leads backwards only, at
/// most limits::max_links_per_keyframe from a keyframe. At most 20 of each are named, and the others counted. Links and
/// ties are in the order of their ids.
void leave_out_unsound_links(Flight& flight);

}  // namespace ilp::intake
