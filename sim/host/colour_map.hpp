// Numbers as colours: viridis (perceptually even, readable without colour vision).
#pragma once

#include "sim/host/png_encode.hpp"

namespace ilp::host {

/// `t` in [0,1], clamped.
[[nodiscard]] Rgb viridis(double t);

struct ValueRange {
  double low = 0, high = 1;
};
/// The 2nd and 98th percentile of the finite values, so that outliers do not eat the colours.
[[nodiscard]] ValueRange display_range(const Raster<float>& values);
/// Values that are not finite become transparent.
[[nodiscard]] Raster<Rgba> colour_mapped(const Raster<float>& values, const ValueRange& range);

}  // namespace ilp::host
