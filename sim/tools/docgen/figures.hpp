// Measured figures of the pages: docs/figures/NAME.json holds a command, columns and rows, and its table stands in a
// page between "<!-- figures: NAME -->" and "<!-- end -->".
//
//   {"command": ["sim/fly"],                                  lines; the first ones of the block
//    "columns": [{"name": "error", "unit": "%"}, ...],        tests/docs_figures/figures says what else a column may
//    have "rows": [["0.12", ...], ...]}                            a text for each column
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::docgen {

/// Command and table in Markdown. Throws std::runtime_error, which names the file, where it is not as above.
[[nodiscard]] std::string figures_table(const std::filesystem::path& file);

/// The names of the blocks of a page, in its order. Throws std::runtime_error where a block has no end.
[[nodiscard]] std::vector<std::string> figures_of(const std::string& page);

/// The page with each block as its file in `folder` has it. Throws std::runtime_error.
[[nodiscard]] std::string with_figures(const std::string& page, const std::filesystem::path& folder);

}  // namespace ilp::docgen
