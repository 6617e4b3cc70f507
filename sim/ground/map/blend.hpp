// Blends the patches of a map: corrects heights near their borders, so that no steps are left.
#pragma once

#include <cstdint>

#include "sim/host/raster.hpp"

namespace ilp::map {

struct BlendParams {
  /// Number of cells over which a step at a border fades on each side. It is large enough to leave no ridge (the slope
  /// changes by a sixth of the step), and small enough that a patch keeps its own heights.
  double fade_cells = 6;
  /// The band about a border: cells at most this far from it. They have the largest errors, because matching windows
  /// and the codec's region end there.
  std::int32_t band_cells = 3;
  /// Weight of small second differences in the band; 0: none. Chosen so that borders are as rough as the rest of the
  /// map (seam_measure.hpp).
  double band_smoothness = 2;
  /// Weight of the patch's own differences in the band; outside it is 1.
  double band_shape = 0.1;
};

/// Adds to `values` the smallest correction, in units of `sigma`, that joins the patches without steps. It solves the
/// screened Poisson equation (Perez et al., "Poisson image editing", SIGGRAPH 2003; Bhat et al., "Fourier analysis of
/// the 2D screened Poisson equation", ECCV 2008). Each patch keeps the differences between its neighbouring cells. The
/// side of a border with the smaller sigma changes less. In the band about a border second differences are kept small.
/// `source`: number of each cell's patch; cells with 0 are left out. `sigma`: standard deviation of `values`, in their
/// unit; `usual_sigma` replaces values that are not positive and finite. Cells further than `blend_reach_cells` from
/// all borders do not change. A cell that far away changes a result by at most a hundredth of its step.
void blend_patches(const host::Raster<std::uint16_t>& source, const host::Raster<float>& sigma, float usual_sigma,
                   const BlendParams& params, host::Raster<float>& values);

inline constexpr std::int32_t blend_reach_cells = 48;

}  // namespace ilp::map
