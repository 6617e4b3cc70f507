// Writes a page in one HTML file, with the script that draws it from the data that it contains.
#pragma once

#include <functional>
#include <initializer_list>
#include <iosfwd>
#include <string>

namespace ilp::report {

/// Data of a page: `write` writes JSON without `<` (JsonWriter) into the element <script id=NAME>.
struct PageData {
  const char* name;
  std::function<void(std::ostream&)> write;
};

/// `without_script`: HTML that a browser without JavaScript shows.
void write_page(const std::string& title, const std::string& without_script, std::initializer_list<PageData> data,
                std::ostream& out);

}  // namespace ilp::report
