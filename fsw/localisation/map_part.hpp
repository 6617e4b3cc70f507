// The data of MapFix, and the part of its work that reads the map: directory and tiles.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/localisation/fix_book.hpp"
#include "fsw/localisation/map_scratch.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "hal/maps/map_source.hpp"

namespace ilp {

using MapTables = StageStore<ComponentId::map_fix>;
using MapStepScratch = StepScratch<MapFixScratch, MapStartScratch>;

/// Number of decoded tiles in memory: at most four that a keyframe touches if the map has the working pixel, and one of
/// the coarsest layer, from which the height of the ground is taken.
inline constexpr std::size_t tiles_at_hand = 5;

enum class MapPhase : std::uint8_t {
  open,
  idle,
  load,
  survey,
  start_image,
  start_features,
  start_compare,
  plan,
  paint,
  search,
  record
};

struct MapWiring {
  MapTables store;
  const MissionParameters& mission;
  MapSource* source;
  MapStepScratch scratch;
};
struct MapState {
  std::int64_t map_id = 0;  ///< the map to which the fixes belong
  FixBook book;
  SmallKeyframes strip;    ///< keyframes of the book's strip, if the map is too coarse for one image
  std::uint32_t lost = 0;  ///< 1: the position was lost and not found again
};
struct alignas(32) MapWork {
  Patience patience;
  MapPhase phase = MapPhase::open;
  bool usable = false;               ///< the directory is in memory
  std::uint64_t directory_mark = 0;  ///< mark of the directory in memory
  bool keeps = false;                ///< the work continues in the shared memory
  std::int64_t refused_a = 0;        ///< a fault of the directory that was reported
  StatusCode refused = StatusCode::ok;
  // The keyframe that is processed; a restart discards it.
  DepthRecord depth;
  PoseRecord pose;
  FixRecord record;
  FixedVector<FixPoint, limits::max_fix_points> points;
  TimeNs time_ns = 0;
  MapPrior prior;
  MapPlan plan;
  double ground_m = 0;       ///< height of the ground that the camera sees
  double scale = 0;          ///< metres per strip unit; 0: not known
  double scale_sigma = 0;    ///< relative standard deviation of `scale`
  std::uint32_t layer = 0;   ///< layer of the map that is compared
  bool relief = false;       ///< heights are compared instead of images
  std::size_t together = 1;  ///< number of keyframes that are registered together
  MapTileRange tiles;
  std::int64_t painted = 0;  ///< number of tiles of the range that were painted
  Status updates;            ///< event about a tile that cannot be used, or about the position
};
struct alignas(32) MapWorkspace {
  MapDirectory directory;
  struct TileAtHand {
    std::size_t entry = limits::max_map_tiles;  ///< index of its directory entry; max_map_tiles: none
    std::uint64_t used = 0;
    MapTile tile;
  };
  std::array<TileAtHand, tiles_at_hand> tiles;
  std::uint64_t uses = 0;
  navigation::MeasuredKeyframes near;  ///< keyframes from whose strip frame the prior of this one follows
  navigation::MeasuredKeyframe keyframe;
  MapState after;
};

/// Reads the directory and the tiles, and chooses the layer and the keyframes that are compared.
class MapPart {
 public:
  MapPart(const MapWiring& wiring, MapWork& work, MapWorkspace& workspace)
      : wiring_(wiring), work_(work), workspace_(workspace) {}

  /// Reads the directory. If the map cannot be used the step does not fail: see work.usable and work.updates.
  void open();
  /// The decoded tile of a directory entry, read if it is not in memory; null if it cannot be used.
  const MapTile* tile(std::size_t entry);
  /// The entry of the tile at a point in the coarsest layer that has one; limits::max_map_tiles if there is none.
  [[nodiscard]] std::size_t coarsest_tile_at(double x_m, double y_m) const;
  /// The layer to compare with an image whose pixel is `image_pixel_m` on the ground, among those with a tile at a
  /// point.
  [[nodiscard]] std::uint32_t layer_for(double image_pixel_m, double x_m, double y_m) const;
  /// Origin of the map's plane.
  [[nodiscard]] BodyPlace origin() const;
  /// Changes work.plan from one keyframe to several, if the map is too coarse for one. `image_pixels` is the ratio of
  /// the map's working pixel to the image's pixel on the ground.
  void plan_together(double image_pixels);

 private:
  [[nodiscard]] std::size_t entry_at(std::uint32_t layer, double x_m, double y_m) const;

  const MapWiring& wiring_;
  MapWork& work_;
  MapWorkspace& workspace_;
};

}  // namespace ilp
