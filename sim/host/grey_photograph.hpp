// Photographs as grey images of 8 bits with as many pixels as the flight takes.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/host/photograph.hpp"
#include "sim/host/raster.hpp"

namespace ilp::host {

/// The 16-bit values that become 0 and 255.
struct GreyRange {
  double black = 0, white = 255;
};
/// The range of photographs of more than 8 bits: a thousandth of the pixels lies beyond each end. Some of them, evenly
/// chosen, stand for many; damaged ones do not count.
[[nodiscard]] GreyRange grey_range(const std::vector<std::filesystem::path>& deep);

/// How many pixels, in x and in y, have to become one so that the flight takes the image.
[[nodiscard]] int binning_for(int width, int height);

/// Means of blocks of pixels; a rest at the right and lower border is left out. `range` counts for more than 8 bits.
[[nodiscard]] Raster<std::uint8_t> grey_of(const Photograph& photograph, int binning, const GreyRange& range);

/// Whether the flight's camera can decode the file, by its first bytes, whatever its name.
[[nodiscard]] bool is_png_or_pgm(const std::filesystem::path& file);

}  // namespace ilp::host
