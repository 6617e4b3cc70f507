// Removes invalid links, ties and fixes from a flight: downlinked records may hold any values.
#pragma once

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Removes invalid links and ties, and adds remarks with the reasons. A link or tie is invalid if it does not lead to
/// an earlier keyframe or strip, its id does not belong to its keyframe, its strip is not that of its keyframes, its
/// verdict is unknown, it has more points than limits::max_link_points, or a value is not finite. The remaining links
/// lead to earlier keyframes, at most limits::max_links_per_keyframe from each. At most 20 links and 20 ties are named
/// in remarks; the others are counted.
void leave_out_invalid_links(Flight& flight);

/// Removes invalid fixes from keyframes, and adds remarks with the reasons. A fix is invalid if its strip is not that
/// of its keyframe, an enumerated value is unknown, a value is not finite, or an accepted fix has an impossible
/// position, attitude or covariance. Also removes navigation records with a value that is not finite.
void leave_out_invalid_fixes(Flight& flight);

}  // namespace ilp::intake
