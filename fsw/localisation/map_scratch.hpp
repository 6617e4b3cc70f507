// Scratch of the localisation of one keyframe, in the shared memory: it is kept from the image to the fix.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/localisation/map_canvas.hpp"
#include "fsw/localisation/map_together.hpp"
#include "fsw/maps/map_tile.hpp"
#include "fsw/vision/map/map_registration.hpp"
#include "fsw/vision/map/map_workspace.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

struct MapFixScratch {
  MapRegistration registration;
  MapKeyframe keyframe;                             ///< its views refer to the members below
  std::array<MapKeyframe, most_together> together;  ///< the keyframe and earlier ones that are registered with it
  KeyframeDepths depths;
  FrameImage image;
  SeenCells seen;
  std::array<float, max_seen_cells> inverse_depth;  ///< 1 / strip unit
  std::array<float, max_seen_cells> depth_m;
  MapCanvas canvas;
  std::array<std::uint8_t, limits::max_map_tile_bytes> file;
  std::array<std::uint8_t, max_map_directory_bytes> directory_file;
  MapTileWorkspace tile;
  MapRegistrationWorkspace work;
};

/// Scratch of a start without a prior.
struct MapStartScratch {
  CameraModel camera;
  FrameImage image;
  std::int32_t factor;
  std::array<std::uint8_t, limits::max_image_pixels> pixels;
  GrayView view;  ///< view of `pixels`: the image reduced by `factor`
  PlaceScratch place;
  PlaceFeatures features;  ///< features of the keyframe
  std::array<std::uint8_t, limits::max_map_tile_bytes> file;
  MapTileFeatures tile;
  PlaceFeatures image_features, shape_features;  ///< features of the tiles that are compared together
  PlaceMatch match;
  std::size_t next;        ///< the next tile to compare, together with its neighbours
  std::size_t best_entry;  ///< first tile of the group that shows the keyframe's ground best; max_map_tiles: none yet
  Similarity2 best;        ///< px of the reduced image from px of the feature pictures, with origin in that tile
  double evidence;         ///< evidence for `best`
  bool knows;              ///< a tile has features
};

}  // namespace ilp
