// Numbers and text for people.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ilp::host {

/// A dash for what is not finite.
[[nodiscard]] std::string fixed(double value, int decimals);
/// About three significant digits.
[[nodiscard]] std::string brief(double value);
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);
[[nodiscard]] std::string duration_text(double seconds);
/// Text for the content or an attribute of an HTML or SVG element; control characters become spaces.
[[nodiscard]] std::string escaped(std::string_view text);
/// "1 keyframe", "3 keyframes"
[[nodiscard]] std::string counted(std::size_t count, const std::string& noun);

/// "; did you mean depth?", with the known word that is spelled most like this one; empty where none is near.
[[nodiscard]] std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

/// "640x480".
[[nodiscard]] std::string size_text(std::int64_t width, std::int64_t height);

}  // namespace ilp::host
