// The pages under docs/ that follow from tables in the code. A test compares the committed pages with these.
#pragma once

#include <string>
#include <vector>

namespace ilp::docgen {

struct Document {
  std::string file;   ///< path of the page from docs/
  std::string text;   ///< Markdown
  bool part = false;  ///< of a written page: between the two lines that begin with part_begins and part_ends
};
inline constexpr const char* part_begins = "<!-- Made by";
inline constexpr const char* part_ends = "<!-- End of what is made";

/// The page with the document in its place. `page` is what stands there now; a page without the two lines stays.
std::string placed(const Document& document, const std::string& page);

/// parameters.md, events.md, records.md, schedule.md and interface-control-document.md; the picture in design.md and
/// the tables of stages on the pages of the rooms. They are the same bytes in every profile and on every machine.
std::vector<Document> generated_documents();

}  // namespace ilp::docgen
