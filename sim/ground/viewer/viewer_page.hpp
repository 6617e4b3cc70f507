// The viewer: one HTML page with the flight in 3D, its script and all its data inside.
#pragma once

#include <iosfwd>
#include <string>

#include "sim/ground/report/report.hpp"

namespace ilp::viewer {

/// False where the build could not make the script (cmake says why).
[[nodiscard]] bool viewer_available();

/// Needs no network and no other file. With viewer_available() only.
void write_viewer_html(const report::Report& report, std::ostream& out);
/// The page of a downlink without usable data, with the reason.
[[nodiscard]] std::string viewer_empty_html(const std::string& title, const std::string& reason);

}  // namespace ilp::viewer
