// The parts of the report's page, each HTML text. What has a part for each keyframe is written one by one.
#pragma once

#include <iosfwd>
#include <string>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

[[nodiscard]] std::string page_summary(const Report& report);
[[nodiscard]] std::string page_strips(const Report& report);
/// Empty without control points.
[[nodiscard]] std::string page_control(const Report& report);
/// Empty where no landing sites were asked for.
[[nodiscard]] std::string page_landing(const Report& report);
/// Empty where no link came down.
[[nodiscard]] std::string page_joined(const Report& report);
/// Empty where no fix record came down.
[[nodiscard]] std::string page_fixes(const Report& report);
[[nodiscard]] std::string page_problems(const Report& report);
[[nodiscard]] std::string page_accuracy(const Report& report);
/// Empty without a score.
[[nodiscard]] std::string page_score(const Report& report);
void page_keyframe_table(const Report& report, std::ostream& out);
/// Empty without capture records.
[[nodiscard]] std::string page_captures(const Report& report);
[[nodiscard]] std::string page_plots(const Report& report);
[[nodiscard]] std::string page_cost(const Report& report);
void page_gallery(const Report& report, std::ostream& out);
[[nodiscard]] std::string page_files(const Report& report);

/// A table cell; `style` is its class ("t" for text).
[[nodiscard]] std::string cell(const std::string& html, const char* style = "");

}  // namespace ilp::report
