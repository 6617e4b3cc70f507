// Decides whether a strip's map is suitable for landing sites, computes them, and writes their files for other tools.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/ground/control/place_by_control.hpp"
#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/landing/landing_safety.hpp"

namespace ilp::landing {

/// Result for one strip.
struct StripLanding {
  std::optional<LandingMap> map;
  std::string fault;  ///< why there is no map
};

/// Computes the landing map from `strip.grid`. The strip must be in metres, and its vertical must be known from the
/// vehicle's navigation or from control points (`control`; null: none). Otherwise `fault` says what is missing.
[[nodiscard]] StripLanding landing_of(const exports::ExportedStrip& strip, const control::StripControl* control,
                                      const LandingLimits& limits);

/// A line for the user at the end of a run.
[[nodiscard]] std::string line_of(const StripLanding& landing, std::int64_t strip);

/// Writes landing-safe, landing-slope, landing-roughness and landing-step SUFFIX .tif: GeoTIFF files with one pixel for
/// each footprint centre, NaN where heights do not cover the footprint. Writes landing-sites SUFFIX .geojson with a
/// polygon for each site, the best first. Adds the names to `strip.files`. Throws std::runtime_error.
void export_landing(const LandingMap& map, const std::filesystem::path& folder, exports::ExportedStrip& strip);

}  // namespace ilp::landing
