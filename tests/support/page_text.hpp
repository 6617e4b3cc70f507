// Reads a page from ilp-ground as its script writes it in a browser.
#pragma once

#include <gtest/gtest.h>

#include "tests/unit/ground/export/tool.hpp"

namespace ilp::test {

/// Returns the HTML of the page after its script has run. Node runs the script, so the test needs
/// ILP_NEED_TOOL("node").
[[nodiscard]] inline std::string page_text(const std::filesystem::path& page) {
  ToolResult run = run_tool("node tests/support/page_text.mjs " + quoted(page));
  EXPECT_EQ(run.status, 0) << page;
  return std::move(run.output);
}

}  // namespace ilp::test
