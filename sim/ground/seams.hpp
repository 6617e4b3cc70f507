// Where the pieces of a strip meet: one surface and one brightness from the masked pieces of its keyframes.
#pragma once

#include "sim/ground/ground_grid.hpp"

namespace ilp::ground {

/// Masks are disjoint, so that between two pieces a cell or two may stay empty. Such a cell, with covered cells of
/// different keyframes within two cells on opposite sides and no cliff between them, takes the height and brightness of
/// the line between these. Its count stays 0: nothing was measured there. Gaps inside a piece stay open: there the
/// matcher found nothing.
void close_seams(GroundGrid& grid);

/// The camera's exposure changes from image to image. One factor per keyframe, from the brightness on both sides of the
/// seams (least squares over the logarithms of their medians), with a mean of one over the map: pictures of the ground
/// for people, not for photometry.
void balance_exposure(GroundGrid& grid);

}  // namespace ilp::ground
