// Script and style of the viewer. The build bundles them; all are empty if it could not.
#pragma once

#include <string_view>

namespace ilp::viewer {

[[nodiscard]] std::string_view script();
[[nodiscard]] std::string_view style();
/// The licence of three.js, which is part of the script.
[[nodiscard]] std::string_view licence();

}  // namespace ilp::viewer
