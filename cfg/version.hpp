// The software version, which is written into products, telemetry and databases.
#pragma once

namespace ilp {
inline constexpr const char* software_version = "0.1.0";
}
