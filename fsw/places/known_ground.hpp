// Which pixels of a keyframe show ground that earlier keyframes have seen at least as well.
#pragma once

#include <array>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/terrain/cell_depths.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp {

/// One bit for each pixel of each cell of SeenCells, row by row: 1 if its ground is known.
using KnownGround = std::array<std::uint64_t, max_seen_cells>;

/// Marks the pixels of `mask` whose ground the other keyframe has seen at least as well. `other_from_camera` maps
/// camera coordinates, each in the unit of its strip. The ground is taken as flat between the middles of cells. Pixels
/// of a cell without depth stay unknown.
void mark_known(MaskView mask, const SeenCells& seen, const CellDepths& depths, const CameraModel& camera,
                const Similarity& other_from_camera, const SeenCells& other, std::int32_t finer_steps,
                KnownGround& known);

/// The same for a keyframe without depth, over the ground's plane: a homography, px to px. How well the keyframe would
/// see the ground is not known, so that all ground that the other one has seen is known.
void mark_known_over_plane(MaskView mask, const Mat3& other_from_keyframe, const SeenCells& other, KnownGround& known);

/// Takes known pixels out of the mask, except within `border_px` of new ground that is not known: errors of the poses
/// do not open gaps in the map. Returns the number of pixels taken.
std::uint32_t take_known(const KnownGround& known, std::int32_t border_px, const ImageView<std::uint8_t>& mask);

}  // namespace ilp
