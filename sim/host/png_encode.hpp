// Pictures as PNG bytes, for files and for embedding.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/host/raster.hpp"

namespace ilp::host {

struct Rgba {
  std::uint8_t r = 0, g = 0, b = 0, a = 0;
};

[[nodiscard]] std::vector<std::uint8_t> png_bytes(const Raster<std::uint8_t>& grey);
[[nodiscard]] std::vector<std::uint8_t> png_bytes(const Raster<Rgba>& picture);

/// `data:image/png;base64,...`
[[nodiscard]] std::string data_uri(const std::vector<std::uint8_t>& png);

}  // namespace ilp::host
