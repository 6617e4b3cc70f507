// Bends the pieces of a map so that they meet.
#pragma once

#include <cstdint>

#include "sim/host/raster.hpp"

namespace ilp::map {

struct BlendParams {
  /// A step at a border fades over this many cells on each side: long enough that no ridge is left (the slope changes
  /// by a sixth of the step), short enough that a piece keeps its own heights.
  double fade_cells = 6;
  /// Cells this close to a border are the last that a matching window, or the codec's region, has reached, and err
  /// most.
  std::int32_t band_cells = 3;
  /// Weight of smoothness in the band against that of the piece's own shape; chosen so that borders are as rough as the
  /// rest of the map (seam_measure.hpp). 0: none.
  double band_smoothness = 2;
  /// Weight of the piece's own shape in the band.
  double band_shape = 0.1;
};

/// Changes `values` by the smallest correction, in units of `sigma`, that lets pieces go over into each other: the
/// screened Poisson equation (Perez et al., "Poisson image editing", SIGGRAPH 2003; Bhat et al., "Fourier analysis of
/// the 2D screened Poisson equation", ECCV 2008). Each piece keeps its differences between neighbours, the better
/// measured side of a border bends less, and in the band about borders second differences are kept small.
/// `source` names the piece of each cell; cells with 0 are left out. `sigma` is in units of `values`; where it is not
/// positive and finite, `usual_sigma` stands for it. Cells further than `blend_reach_cells` from all borders do not
/// change, and no cell depends by more than a hundredth of a step on cells that far away.
void blend_patches(const host::Raster<std::uint16_t>& source, const host::Raster<float>& sigma, float usual_sigma,
                   const BlendParams& params, host::Raster<float>& values);

inline constexpr std::int32_t blend_reach_cells = 48;

}  // namespace ilp::map
