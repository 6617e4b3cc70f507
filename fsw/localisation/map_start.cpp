#include "fsw/localisation/map_start.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/localisation/map_prior.hpp"
#include "fsw/localisation/reduced_image.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr std::int32_t most_reduction = 12;
// Without the height of the camera, keyframes take turns: features bear twice another scale.
constexpr std::int32_t reductions[] = {1, 2, 4};
constexpr std::int32_t least_side = 96;  // px, of a reduced image
// Errors of the place that features give: relief between tile and image, tilt of the camera.
constexpr double place_px = 4;
constexpr double tilt_rad = 0.035, heading_rad = 0.035;
constexpr double height_share = 0.04;

}  // namespace

/// Such that a pixel is about as large as those of the pictures in which the finest layer's features were found.
std::int32_t MapStart::reduction() const {
  const MapStartScratch& memory = scratch();
  const navigation::MeasuredKeyframe& keyframe = workspace_.keyframe;
  const std::int32_t most =
      std::min({most_reduction, memory.image.view().width / least_side, memory.image.view().height / least_side});
  std::int32_t factor = reductions[static_cast<std::size_t>(work_.record.id) % std::size(reductions)];
  if (keyframe.height_sigma_m > 0) {
    const double pixel_m = workspace_.directory.layers[0].pixel_m / map_feature_zoom;
    const double ratio = pixel_m * memory.camera.fx / keyframe.height_m;
    factor = static_cast<std::int32_t>(std::clamp(ratio + 0.5, 1.0, static_cast<double>(most_reduction)));
  }
  return std::clamp(factor, 1, std::max(most, 1));
}

Status MapStart::load_image() {
  MapStartScratch& memory = scratch();
  ILP_TRY(load_camera(wiring_.store, memory.camera));
  ILP_TAKE(const bool seen, found_by(load_keyframe_image(wiring_.store, work_.record.id, memory.image)));
  work_.phase = MapPhase::record;
  if (!seen) return {};
  memory.factor = reduction();
  const GrayView image = memory.image.view();
  const MutableGrayView view(memory.pixels.data(), image.width / memory.factor, image.height / memory.factor);
  mean_of_squares(image, memory.factor, view);
  memory.view = view;
  memory.best = {};
  memory.best_entry = limits::max_map_tiles;
  memory.next = 0;
  memory.knows = false;
  work_.keeps = true;
  work_.phase = MapPhase::start_features;
  return begin_place_features(memory.view, memory.place.features, memory.features);
}

Status MapStart::find_features() {
  MapStartScratch& memory = scratch();
  work_.keeps = true;
  ILP_TAKE(const bool more, place_features_slice(memory.view, limits::place_features, memory.place.harris,
                                                 memory.place.features, memory.features));
  if (!more) work_.phase = MapPhase::start_compare;
  return {};
}

/// Those of the tile so many rows and columns beside the first one. A tile that has not come has none.
void MapStart::add_features(std::size_t first, std::int32_t rows, std::int32_t columns) {
  MapStartScratch& memory = scratch();
  const MapDirectory& map = workspace_.directory;
  const MapTileEntry& place = map.tiles[first];
  const std::size_t entry = find_map_tile(map, place.layer, place.row + rows, place.column + columns);
  if (entry >= map.tiles.size()) return;
  std::size_t size = 0;
  const MapTilePlace at{place.layer, map.tiles[entry].row, map.tiles[entry].column};
  Status status = wiring_.source->read_tile(at, memory.file, size);
  // A tile may come later.
  if (status.is(StatusCode::not_found)) return;
  if (status.ok()) status = read_map_features(std::span(memory.file).first(size), map, entry, memory.tile);
  if (!status.ok()) {
    work_.updates = {StatusCode::map_tile_unusable, static_cast<std::int64_t>(entry),
                     static_cast<std::int64_t>(status.code)};
    return;
  }
  const auto add = [&](const MapFeatures& from, PlaceFeatures& to) {
    for (PlaceFeature feature : from) {
      feature.x = (feature.x + static_cast<float>(columns * map_tile_side) + 0.5F) * map_feature_zoom - 0.5F;
      feature.y = (feature.y + static_cast<float>(rows * map_tile_side) + 0.5F) * map_feature_zoom - 0.5F;
      static_cast<void>(to.push_back(feature));
    }
  };
  add(memory.tile.image, memory.image_features);
  add(memory.tile.shape, memory.shape_features);
  memory.knows = memory.knows || !memory.tile.image.empty() || !memory.tile.shape.empty();
}

/// With the tile to the east, the one to the south, and the one between: an image lies across borders.
Status MapStart::compare_from(std::size_t entry) {
  MapStartScratch& memory = scratch();
  memory.image_features.clear();
  memory.shape_features.clear();
  for (std::int32_t k = 0; k < 4; ++k) add_features(entry, k / 2, k % 2);
  for (const PlaceFeatures* list : {&memory.image_features, &memory.shape_features}) {
    ILP_TRY(verify_place({list->data(), list->size()}, {memory.features.data(), memory.features.size()},
                         least_place_evidence, memory.place.match, memory.match));
    const bool better = memory.match.verdict == PlaceVerdict::verified &&
                        (memory.best_entry == limits::max_map_tiles || memory.match.evidence > memory.evidence);
    if (!better) continue;
    memory.best = memory.match.newer_from_older;
    memory.evidence = memory.match.evidence;
    memory.best_entry = entry;
  }
  return {};
}

/// One tile and those beside it in each step.
Status MapStart::compare() {
  MapStartScratch& memory = scratch();
  work_.keeps = true;
  if (memory.next < workspace_.directory.tiles.size()) ILP_TRY(compare_from(memory.next++));
  if (memory.next < workspace_.directory.tiles.size()) return {};
  work_.keeps = false;
  conclude();
  return {};
}

/// The similarity of the images as a pose above the tile's ground, whose height is looked up when it is surveyed.
void MapStart::conclude() {
  const MapStartScratch& memory = scratch();
  work_.phase = MapPhase::record;
  // No file of a tile has come, all are damaged, or the map was made without features.
  work_.record.verdict = memory.knows ? MapVerdict::no_agreement : MapVerdict::no_map;
  const bool found = memory.best_entry < limits::max_map_tiles && memory.best.scale > 0;
  if (!found) return;
  const MapTileEntry& entry = workspace_.directory.tiles[memory.best_entry];
  const MapLayer& layer = workspace_.directory.layers[entry.layer];
  const double factor = memory.factor, scale = memory.best.scale;
  // Of the principal point: reduced px, then px of the pictures of features, then of the tile.
  const double u = (memory.camera.cx - 0.5 * (factor - 1)) / factor - memory.best.shift_x_px;
  const double v = (memory.camera.cy - 0.5 * (factor - 1)) / factor - memory.best.shift_y_px;
  const double cosine = det_cos(memory.best.rotation_rad), sine = det_sin(memory.best.rotation_rad);
  const double column = ((cosine * u + sine * v) / scale + 0.5) / map_feature_zoom;
  const double row = ((-sine * u + cosine * v) / scale + 0.5) / map_feature_zoom;
  const double x = layer.x0_m + layer.pixel_m * (map_tile_side * entry.column + column);
  const double y = layer.y0_m - layer.pixel_m * (map_tile_side * entry.row + row);
  const double distance = layer.pixel_m / (map_feature_zoom * scale * factor) * memory.camera.fx;

  // Straight down: columns of the tile go east and its rows south, as x and y of a camera that looks down.
  Mat3 down;
  down << cosine, sine, 0, sine, -cosine, 0, 0, 0, -1;
  work_.prior = {};
  work_.prior.camera_from_map.rotation = down;
  const Vec3 centre(x, y, distance);
  work_.prior.camera_from_map.translation = -(down * centre);
  const double place_m = place_px * layer.pixel_m, height_m = height_share * distance;
  const Mat3 attitude = Vec3(tilt_rad * tilt_rad, tilt_rad * tilt_rad, heading_rad * heading_rad).asDiagonal();
  work_.prior.covariance =
      covariance_over_ground(down, distance, attitude, Vec3(place_m * place_m, place_m * place_m, height_m * height_m));
  work_.record.prior = FixPrior::search;
  work_.record.verdict = MapVerdict::no_map;
  work_.phase = MapPhase::load;
}

}  // namespace ilp
