// A page in one file that its script draws of its data.
#pragma once

#include <functional>
#include <initializer_list>
#include <iosfwd>
#include <string>

namespace ilp::report {

/// JSON for the element <script id=NAME>, with no `<` in it (JsonWriter).
struct PageData {
  const char* name;
  std::function<void(std::ostream&)> write;
};

/// `without_script` is what a browser without JavaScript shows, as HTML.
void write_page(const std::string& title, const std::string& without_script, std::initializer_list<PageData> data,
                std::ostream& out);

}  // namespace ilp::report
