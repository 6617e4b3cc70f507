// Converts reports of gpsd to navigation samples.
#pragma once

#include <gps.h>

#include "fsw/base/navigation_sample.hpp"
#include "fsw/packets/time_code.hpp"

namespace ilp::gps {

/// Converts a position report (TPV) to a sample: longitude, latitude, and where known with their errors the height
/// above the ellipsoid and the velocity. gpsd's errors of 95 % become one sigma. `utc` gets the time of the fix.
/// Returns false if position, its error or its time is not known.
[[nodiscard]] bool sample_of(const gps_fix_t& fix, NavigationSample& sample, UtcNs& utc);

}  // namespace ilp::gps
