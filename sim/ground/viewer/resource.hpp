// The viewer's texts as the build made them; all empty where it could not.
#pragma once

#include <string_view>

namespace ilp::ground::viewer {

[[nodiscard]] std::string_view script();
[[nodiscard]] std::string_view style();
/// Of three.js, which is part of the script.
[[nodiscard]] std::string_view licence();

}  // namespace ilp::ground::viewer
