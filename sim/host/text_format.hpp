// Formats numbers and text for people.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ilp::host {

/// `value` with this number of decimals; a dash if it is not finite.
[[nodiscard]] std::string fixed(double value, int decimals);
/// `value` with about three significant digits; a dash if it is not finite.
[[nodiscard]] std::string brief(double value);
/// "12 B", "3.40 kB", "56.78 MB": decimal prefixes.
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);
[[nodiscard]] std::string duration_text(double seconds);
/// Escapes text for the content or an attribute of an HTML or SVG element. Control characters become spaces.
[[nodiscard]] std::string escaped(std::string_view text);
/// "1 keyframe", "3 keyframes"
[[nodiscard]] std::string counted(std::size_t count, const std::string& noun);

/// "; did you mean depth?", with the known word of the nearest spelling; empty if no word is near.
[[nodiscard]] std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

/// "640x480".
[[nodiscard]] std::string size_text(std::int64_t width, std::int64_t height);

}  // namespace ilp::host
