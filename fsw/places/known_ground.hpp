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

/// A keyframe whose ground may be known: `mask` says which pixels count, `seen` and `depths` are of its cells.
struct NewView {
  MaskView mask;
  const SeenCells& seen;
  const CellDepths& depths;
  const CameraModel& camera;
};

/// A keyframe that may have seen the ground before. `other_from_camera` maps camera coordinates, each in the unit of
/// its strip, and puts the ground within `error_px` of its place.
struct EarlierView {
  const SeenCells& seen;
  Similarity other_from_camera;
  double error_px = 0;
};

/// Marks the pixels whose ground the earlier keyframe has seen at least as well: from less than `claim_ratio` times the
/// distance of the new view, or with an error of the distance that is not larger. The ground is taken as flat between
/// the middles of cells. Pixels without depth in their cell or the cells around it stay unknown.
void mark_known(const NewView& view, const EarlierView& earlier, double claim_ratio, KnownGround& known);

/// The same for a keyframe without depth, over the ground's plane: a homography, px to px. How well the keyframe would
/// see the ground is not known, so that all ground that the other one has seen is known.
void mark_known_over_plane(MaskView mask, const Mat3& other_from_keyframe, const SeenCells& other, KnownGround& known);

/// Takes known pixels out of the mask, and with them slivers: pixels that no square of new pixels with sides of
/// `sliver_px` contains. Known pixels within `border_px` of new ground that is not known stay: errors of the poses do
/// not open gaps in the map. What is left of the mask goes too if it is less than a cell. Nothing changes where no
/// pixel is known. In slices, from part 0 on while they return true; between them the mask holds marks. `taken` is the
/// number of pixels.
bool take_known_slice(const KnownGround& known, std::int32_t sliver_px, std::int32_t border_px,
                      const ImageView<std::uint8_t>& mask, std::size_t part, std::uint32_t& taken);

}  // namespace ilp
