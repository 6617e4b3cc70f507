// Reports of gpsd as navigation samples.
#pragma once

#include <gps.h>

#include "fsw/base/navigation_sample.hpp"
#include "fsw/packets/time_code.hpp"

namespace ilp::gps {

/// What gpsd knows of a position (TPV): longitude and latitude, the height above the ellipsoid and the velocity, where
/// they are known with their errors. `utc` gets the time of the fix. False without a position, its error or its time.
[[nodiscard]] bool sample_of(const gps_fix_t& fix, NavigationSample& sample, UtcNs& utc);

}  // namespace ilp::gps
