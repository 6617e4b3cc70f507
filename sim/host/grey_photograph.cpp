#include "sim/host/grey_photograph.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string_view>

#include "cfg/limits.hpp"

namespace ilp::host {
namespace {

/// Images of a strip from which the range of 16-bit values is taken.
constexpr std::size_t images_for_range = 16;
/// Share of the pixels that may lie beyond each end of the range.
constexpr double share_beyond = 0.001;

}  // namespace

GreyRange grey_range(const std::vector<std::filesystem::path>& deep) {
  std::vector<std::uint64_t> counts(65536);
  std::uint64_t pixels = 0;
  const std::size_t step = std::max<std::size_t>(1, deep.size() / images_for_range);
  for (std::size_t i = 0; i < deep.size(); i += step) {
    try {
      for (const std::uint16_t value : read_photograph(deep[i]).grey.samples) {
        ++counts[value];
        ++pixels;
      }
    } catch (const DamagedPhotograph&) {
      continue;  // named when it is converted
    }
  }
  const auto level = [&](double share) {
    const double wanted = share * static_cast<double>(pixels);
    double below = 0;
    for (std::size_t value = 0; value < counts.size(); ++value) {
      below += static_cast<double>(counts[value]);
      if (below > wanted) return static_cast<double>(value);
    }
    return 65535.0;
  };
  GreyRange range{level(share_beyond), level(1 - share_beyond)};
  if (range.white <= range.black) range.white = range.black + 1;
  return range;
}

int binning_for(int width, int height) {
  const auto times = [](int size, std::int32_t most) { return (size + most - 1) / most; };
  return std::max({1, times(width, limits::max_image_width), times(height, limits::max_image_height)});
}

Raster<std::uint8_t> grey_of(const Photograph& photograph, int binning, const GreyRange& range) {
  const Raster<std::uint16_t>& grey = photograph.grey;
  Raster<std::uint8_t> result(grey.width / binning, grey.height / binning);
  const GreyRange used = photograph.deep ? range : GreyRange{};
  const double scale = 255 / (used.white - used.black) / (binning * binning);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      double sum = 0;
      for (int v = 0; v < binning; ++v) {
        for (int u = 0; u < binning; ++u) sum += grey.at(x * binning + u, y * binning + v) - used.black;
      }
      result.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(sum * scale, 0.0, 255.0)));
    }
  }
  return result;
}

bool is_png_or_pgm(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  char begin[2] = {};
  in.read(begin, sizeof(begin));
  const std::string_view bytes(begin, sizeof(begin));
  return in.good() && (bytes == "P5" || bytes == "\x89P");
}

}  // namespace ilp::host
