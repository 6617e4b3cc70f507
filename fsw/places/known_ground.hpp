// Finds the pixels of a keyframe that show ground which earlier keyframes have seen at least as well, and removes them
// from its mask.
#pragma once

#include <array>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/terrain/cell_depths.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp {

/// One bit for each pixel of each cell of SeenCells, row by row: 1 if its ground is known.
using KnownGround = std::array<std::uint64_t, max_seen_cells>;

/// The new keyframe, whose ground may be known.
struct NewView {
  MaskView mask;             ///< pixels that are examined
  const SeenCells& seen;     ///< how well its cells show the ground
  const CellDepths& depths;  ///< inverse depths of its cells
  const CameraModel& camera;
};

/// A keyframe that may have seen the ground before.
struct EarlierView {
  const SeenCells& seen;         ///< how well its cells show the ground
  Similarity other_from_camera;  ///< its camera frame from that of the new keyframe, each in the unit of its strip
  double error_px = 0;           ///< error of a ground point in its image due to `other_from_camera`
};

/// Marks the pixels whose ground the earlier keyframe has seen at least as well: from less than `claim_ratio` times the
/// distance of the new view, or with a distance error that is not larger. The ground is taken as flat between the
/// centres of cells. Pixels without depth in their cell or the cells around it are not marked.
void mark_known(const NewView& view, const EarlierView& earlier, double claim_ratio, KnownGround& known);

/// The same for a keyframe without depth, with the homography `other_from_keyframe` of the ground plane, px to px. All
/// ground that the other keyframe has seen counts as known, because it is not known how well the new one would see it.
void mark_known_over_plane(MaskView mask, const Mat3& other_from_keyframe, const SeenCells& other, KnownGround& known);

/// Removes known pixels from the mask, and also slivers: pixels that are in no square of new pixels with sides of
/// `sliver_px`. Known pixels within `border_px` of unknown new ground stay, so that errors of the poses do not open
/// gaps in the map. If less than a cell is left of the mask, it is removed too. If no pixel is known, the mask is
/// unchanged. The work is done in slices: call it with part 0, 1, ... while it returns true; in between the mask
/// contains marks. `taken` is the number of removed pixels.
bool take_known_slice(const KnownGround& known, std::int32_t sliver_px, std::int32_t border_px,
                      const ImageView<std::uint8_t>& mask, std::size_t part, std::uint32_t& taken);

}  // namespace ilp
