// The pages under docs/ that follow from tables in the code. A test compares the committed pages with these.
#pragma once

#include <string>
#include <vector>

namespace ilp::sim {

struct Document {
  std::string file;  ///< name of the page, without folder
  std::string text;  ///< Markdown
};

/// parameters.md, events.md, records.md, schedule.md and interface-control-document.md, the same bytes in every profile
/// and on every machine.
std::vector<Document> generated_documents();

}  // namespace ilp::sim
