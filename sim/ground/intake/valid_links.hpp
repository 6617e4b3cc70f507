// Links, ties and fixes that came down, whose records may hold anything.
#pragma once

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Leaves out each link and tie that no flight makes, and names it with the reason in the remarks: one that does not
/// lead to an earlier keyframe or strip, has a number that is not its keyframe's, another strip than its keyframes, an
/// unknown verdict, more points than a link has, or a value that is no number. What is left leads backwards only, at
/// most limits::max_links_per_keyframe from a keyframe. At most 20 of each are named, and the others counted. Links and
/// ties are in the order of their ids.
void leave_out_invalid_links(Flight& flight);

/// Takes the fix from each keyframe whose fix no flight makes, and says so in the remarks: one of another strip, with
/// an unknown verdict, body or other word, a value that is no number, or a place, attitude or error that is none.
/// Likewise the vehicle's measurements with a value that is no number.
void leave_out_invalid_fixes(Flight& flight);

}  // namespace ilp::intake
