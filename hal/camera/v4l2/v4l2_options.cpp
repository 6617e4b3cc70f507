#include "hal/camera/v4l2/v4l2_options.hpp"

#include <cstring>

#include "hal/posix/number.hpp"

namespace ilp {
namespace {

constexpr int most_digits = 9;

/// Hertz with up to three decimals, in mHz.
bool read_rate(const char*& text, std::int64_t& rate_mhz) {
  if (!read_digits(text, 5, rate_mhz)) return false;
  std::int64_t unit = 1000;
  rate_mhz *= unit;
  if (*text != '.') return rate_mhz > 0;
  for (++text; *text >= '0' && *text <= '9' && unit > 1; ++text) {
    unit /= 10;
    rate_mhz += (*text - '0') * unit;
  }
  return rate_mhz > 0;
}

bool read_format(const char*& text, const PixelFormat*& format) {
  char name[16] = {};
  for (std::size_t i = 0; i + 1 < sizeof(name) && *text != 0 && *text != ','; ++i) name[i] = *text++;
  format = find_pixel_format(name);
  return format != nullptr;
}

bool read_setting(const char*& text, V4l2Options& options) {
  struct {
    const char* name;
    std::int64_t* value;
  } const numbers[] = {{"input=", &options.input},
                       {"exposure_us=", &options.exposure_us},
                       {"gain=", &options.gain},
                       {"gain_unit=", &options.gain_unit},
                       {"stamp_delay_us=", &options.stamp_delay_us}};
  const auto take = [&text](const char* name) {
    const std::size_t size = std::strlen(name);
    if (std::strncmp(text, name, size) != 0) return false;
    text += size;
    return true;
  };
  if (take("format=")) return read_format(text, options.format);
  if (take("rate=")) return read_rate(text, options.rate_mhz);
  for (const auto& number : numbers) {
    if (take(number.name)) return read_digits(text, most_digits, *number.value) && options.gain_unit > 0;
  }
  return false;
}

}  // namespace

Status parse_v4l2_options(const char* text, V4l2Options& options) {
  options = {};
  const char* const begin = text;
  std::size_t size = 0;
  for (; *text != 0 && *text != ','; ++text) {
    if (size + 1 == sizeof(options.device)) {
      return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(size + 1), sizeof(options.device) - 1};
    }
    options.device[size++] = *text;
  }
  if (size == 0) return {StatusCode::parse_error, 0};
  // Every turn consumes characters of the text.
  while (*text != 0) {
    if (*text == ',') ++text;
    if (!read_setting(text, options) || (*text != 0 && *text != ',')) return {StatusCode::parse_error, text - begin};
  }
  return {};
}

}  // namespace ilp
