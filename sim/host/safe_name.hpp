// Makes names that came down safe for files and pages.
#pragma once

#include <string>
#include <string_view>

namespace ilp::host {

/// The last path component, with everything but letters, digits and `._-+@` replaced by `_`; empty for none or dots
/// only.
[[nodiscard]] std::string safe_name(std::string_view name);
/// The name without its extension.
[[nodiscard]] std::string stem(std::string_view name);
/// KKKKKK
[[nodiscard]] std::string six_digits(std::int64_t number);

}  // namespace ilp::host
