// Writes the viewer: one HTML page that shows the flight in 3D and contains its script and all its data.
#pragma once

#include <iosfwd>
#include <string>

#include "sim/ground/report/report.hpp"

namespace ilp::viewer {

/// False if the build could not make the script (cmake says why).
[[nodiscard]] bool viewer_available();

/// Writes the page, which needs no network and no other file. viewer_available() must be true.
void write_viewer_html(const report::Report& report, std::ostream& out);
/// The page for a downlink without usable data. It shows `reason`.
[[nodiscard]] std::string viewer_empty_html(const std::string& title, const std::string& reason);

}  // namespace ilp::viewer
