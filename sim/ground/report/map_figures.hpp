// Figures of the page that are computed: pictures inside SVG with what is drawn over them. Each is a <figure> element.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// Orthoimage, heights and an oblique view; empty without a grid.
[[nodiscard]] std::vector<std::string> figures_of_strip(const intake::Flight& flight, const StripResult& strip);
/// Of a strip with a map of landing sites.
[[nodiscard]] std::string figure_of_landing(const intake::Flight& flight, const StripResult& strip);
/// Track and fixes on the map; empty where no fix places the strip.
[[nodiscard]] std::string figure_of_fixes(const Report& report, const fixes::StripFixes& strip);
/// The map of height errors in colours, cut to what was mapped; empty without a map.
[[nodiscard]] std::string figure_of_height_errors(const ScoreFile& score);

}  // namespace ilp::report
