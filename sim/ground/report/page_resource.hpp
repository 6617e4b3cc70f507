// Script and style of the page. The build makes them from the files in page/.
#pragma once

#include <string_view>

namespace ilp::report {

[[nodiscard]] std::string_view page_script();
[[nodiscard]] std::string_view page_style();

}  // namespace ilp::report
