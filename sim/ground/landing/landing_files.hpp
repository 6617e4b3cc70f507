// Landing sites of a strip: when a map can say anything of them, and the files for other tools.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/ground/control/place_by_control.hpp"
#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/landing/landing_safety.hpp"

namespace ilp::landing {

/// Of a strip that was asked for landing sites.
struct StripLanding {
  std::optional<LandingMap> map;
  std::string fault;  ///< why there is no map
};

/// A map tells landing sites only if it is in metres and knows what is up, by the vehicle's navigation or by control
/// points (`control`, may be null); `fault` says what is missing. `strip.grid` is the map.
[[nodiscard]] StripLanding landing_of(const exports::ExportedStrip& strip, const control::StripControl* control,
                                      const LandingLimits& limits);

/// What was found, for the end of a run.
[[nodiscard]] std::string line_of(const StripLanding& landing, std::int64_t strip);

/// landing-safe, landing-slope, landing-roughness and landing-step SUFFIX .tif, GeoTIFF on the centres of the
/// footprints, NaN where a footprint is not covered by heights, and landing-sites SUFFIX .geojson, a polygon of each
/// footprint, the best first. Adds the names to `strip.files`. Throws std::runtime_error.
void export_landing(const LandingMap& map, const std::filesystem::path& folder, exports::ExportedStrip& strip);

}  // namespace ilp::landing
