// The version that products, telemetry and databases carry.
#pragma once

namespace ilp {
inline constexpr const char* software_version = "0.1.0";
}
