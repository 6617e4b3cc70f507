// Writes tables of measurements into pages: docs/figures/NAME.json has a command, columns and rows, and its table is in
// a page between "<!-- figures: NAME -->" and "<!-- end -->".
//
//   {"command": ["sim/fly"],                            lines of the command, printed above the table
//    "columns": [{"name": "error", "unit": "%"}, ...],  for other members see tests/docs_figures/figures
//    "rows": [["0.12", ...], ...]}                      a text for each column
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::docgen {

/// Command and table of a file in Markdown. Throws std::runtime_error that names the file if it does not have this
/// form.
[[nodiscard]] std::string figures_table(const std::filesystem::path& file);

/// Names of the blocks of a page, in the order of the page. Throws std::runtime_error if a block has no end.
[[nodiscard]] std::vector<std::string> figures_of(const std::string& page);

/// The page with the content of each block replaced by the table of its file in `folder`. Throws std::runtime_error.
[[nodiscard]] std::string with_figures(const std::string& page, const std::filesystem::path& folder);

}  // namespace ilp::docgen
