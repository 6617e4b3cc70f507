// Generates the pages under docs/ that follow from tables in the code. A test compares the committed pages with them.
#pragma once

#include <string>
#include <vector>

namespace ilp::docgen {

struct Document {
  std::string file;   ///< path of the page from docs/
  std::string text;   ///< Markdown
  bool part = false;  ///< a part of a hand-written page, between the lines of part_begins and part_ends
};
inline constexpr const char* part_begins = "<!-- Made by";
inline constexpr const char* part_ends = "<!-- End of what is made";

/// The new content of the document's page. `page` is the current content. A `part` replaces the text between the two
/// lines; a page without these lines stays unchanged.
std::string placed(const Document& document, const std::string& page);

/// Generates parameters.md, events.md, records.md, schedule.md and interface-control-document.md, the picture in
/// design.md, and the tables of stages on the pages of the stages' folders. The bytes are the same in every profile and
/// on every machine.
std::vector<Document> generated_documents();

}  // namespace ilp::docgen
