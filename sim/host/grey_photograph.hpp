// Converts photographs to 8-bit grey images that are small enough for the flight.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/host/photograph.hpp"
#include "sim/host/raster.hpp"

namespace ilp::host {

/// The sample values that become 0 and 255.
struct GreyRange {
  double black = 0, white = 255;
};
/// Common range of photographs with more than 8 bits: 0.1 % of the pixels lie beyond each end. Uses at most 31
/// of the photographs, evenly chosen, and skips damaged ones.
[[nodiscard]] GreyRange grey_range(const std::vector<std::filesystem::path>& deep);

/// Smallest binning factor (pixels in x and in y that become one) with which the flight takes the image; at least 1.
[[nodiscard]] int binning_for(int width, int height);

/// Mean grey of blocks of `binning` x `binning` pixels. Incomplete blocks at the right and lower border are left out.
/// `range` is used for photographs with more than 8 bits only.
[[nodiscard]] Raster<std::uint8_t> grey_of(const Photograph& photograph, int binning, const GreyRange& range);

/// Whether the first bytes are those of PNG or binary PGM, which the flight's camera decodes. The name is ignored.
[[nodiscard]] bool is_png_or_pgm(const std::filesystem::path& file);

}  // namespace ilp::host
