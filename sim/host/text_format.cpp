#include "sim/host/text_format.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "bsp/flight/nearest_word.hpp"

namespace ilp::host {

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  std::array<char, 64> buffer{};
  if (std::fabs(value) >= 1e12) {
    std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
  } else {
    std::snprintf(buffer.data(), buffer.size(), "%.*f", decimals, value);
  }
  return buffer.data();
}

std::string brief(double value) {
  const double size = std::fabs(value);
  if (!std::isfinite(value)) return "–";
  if (size == 0) return "0";
  if (size >= 100) return fixed(value, 0);
  if (size >= 10) return fixed(value, 1);
  if (size >= 1) return fixed(value, 2);
  if (size >= 0.01) return fixed(value, 3);
  if (size >= 0.0001) return fixed(value, 5);
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.2g", value);
  return buffer.data();
}

std::string bytes_text(std::uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 1000) return std::to_string(bytes) + " B";
  if (bytes < 1000000) return fixed(value / 1e3, value < 1e4 ? 2 : 1) + " kB";
  return fixed(value / 1e6, 2) + " MB";
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "–";
  if (seconds < 1e-3) return fixed(seconds * 1e6, 0) + " µs";
  if (seconds < 1) return fixed(seconds * 1e3, seconds < 0.1 ? 1 : 0) + " ms";
  if (seconds < 120) return fixed(seconds, 1) + " s";
  return fixed(seconds / 60, 1) + " min";
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return safe;
}

std::string size_text(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  NearestWord nearest(word.c_str());
  for (const std::string& candidate : known) nearest.offer(candidate.c_str());
  return nearest.found() == nullptr ? std::string() : "; did you mean " + std::string(nearest.found()) + "?";
}

std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace ilp::host
