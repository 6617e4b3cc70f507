// What MapFix keeps, and what every part of its work has.
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

/// Tiles at hand, decoded: a keyframe touches four at most where the map has the working pixel, and one of the coarsest
/// layer has said how high its ground is.
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
  std::int64_t map_id = 0;  ///< of the map to which the fixes belong
  FixBook book;
  SmallKeyframes strip;    ///< of the book's strip, where the map is too coarse for one image
  std::uint32_t lost = 0;  ///< 1: the place was lost, and has not been found again
};
struct alignas(32) MapWork {
  Patience patience;
  MapPhase phase = MapPhase::open;
  bool usable = false;               ///< the directory is in memory
  std::uint64_t directory_mark = 0;  ///< of the one that is
  bool keeps = false;                ///< the work goes on in the step's memory
  std::int64_t refused_a = 0;        ///< a fault of the directory that was reported
  StatusCode refused = StatusCode::ok;
  // The keyframe at work; a restart drops it.
  DepthRecord depth;
  PoseRecord pose;
  FixRecord record;
  FixedVector<FixPoint, limits::max_fix_points> points;
  TimeNs time_ns = 0;
  MapPrior prior;
  MapPlan plan;
  double ground_m = 0;       ///< height of the ground that the camera sees
  double scale = 0;          ///< metres in a strip unit; 0: not known
  double scale_sigma = 0;    ///< relative
  std::uint32_t layer = 0;   ///< of the map, that is compared
  bool relief = false;       ///< heights are compared, and no light
  std::size_t together = 1;  ///< keyframes that are registered together
  MapTileRange tiles;
  std::int64_t painted = 0;  ///< tiles of the range
  Status updates;            ///< of a tile that cannot be used, or of the place
};
struct alignas(32) MapWorkspace {
  MapDirectory directory;
  struct TileAtHand {
    std::size_t entry = limits::max_map_tiles;  ///< none
    std::uint64_t used = 0;
    MapTile tile;
  };
  std::array<TileAtHand, tiles_at_hand> tiles;
  std::uint64_t uses = 0;
  navigation::MeasuredKeyframes near;  ///< keyframes whose frame says where this one stands
  navigation::MeasuredKeyframe keyframe;
  MapState after;
};

/// The directory and the tiles, and the keyframes that are compared with them.
class MapPart {
 public:
  MapPart(const MapWiring& wiring, MapWork& work, MapWorkspace& workspace)
      : wiring_(wiring), work_(work), workspace_(workspace) {}

  /// Reads the directory. A map that cannot be used is no fault of the step: see work.usable and work.updates.
  void open();
  /// The decoded tile of an entry; null where it cannot be used. One that is not at hand is read.
  const MapTile* tile(std::size_t entry);
  /// The coarsest layer with a tile at a place; its entry. limits::max_map_tiles: there is none.
  [[nodiscard]] std::size_t coarsest_tile_at(double x_m, double y_m) const;
  /// The layer to compare with an image whose pixel is so large on the ground.
  [[nodiscard]] std::uint32_t layer_for(double image_pixel_m, double x_m, double y_m) const;
  [[nodiscard]] BodyPlace origin() const;
  /// work.plan of one keyframe becomes that of the latest ones together, where the map is too coarse for one, with so
  /// many image pixels in its pixel.
  void plan_together(double image_pixels);

 private:
  [[nodiscard]] std::size_t entry_at(std::uint32_t layer, double x_m, double y_m) const;

  const MapWiring& wiring_;
  MapWork& work_;
  MapWorkspace& workspace_;
};

}  // namespace ilp
