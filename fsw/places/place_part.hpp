// The data of PlaceMemory, and the base class of its parts: recall, links, and the mask of new ground.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/places/known_ground.hpp"
#include "fsw/places/place_table.hpp"
#include "fsw/places/strip_tie.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/vision/multiview/link_geometry.hpp"
#include "fsw/vision/place/place_index.hpp"
#include "fsw/vision/place/place_patches.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "fsw/vision/place/place_verification.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

using PlaceTables = StageStore<ComponentId::place_memory>;
using PlaceStepScratch = StepScratch<PlaceScratch, PlaceQueryWorkspace, LinkGeometryWorkspace>;

/// Number of successive keyframes of a strip that are well connected by their pairs, and whose ground is in the
/// coverage.
inline constexpr std::int64_t chained_keyframes = 8;

enum class PlacePhase : std::uint8_t { recall, idle, load, features, patches, search, compare, narrow, cut, record };

struct PlaceWiring {
  PlaceTables store;
  const MissionParameters& mission;
  PlaceStepScratch scratch;
};
struct PlaceState {
  std::int64_t bare_id = 0;  ///< newest place without features: its record is erased with the next one
  StripLinks links;          ///< links of the newest strip
};
struct PlaceWork {
  Patience patience;
  CameraModel camera;
  // The keyframe that is processed; a restart discards it.
  PlacePhase phase = PlacePhase::recall;
  std::int64_t recalled_id = 0;
  DepthRecord depth;
  MaskRecord mask;  ///< id 0: there is no mask any more
  KeyframeRecord keyframe;
  PoseRecord pose;
  double ground_distance = 0;
  FixedVector<std::uint16_t, 3 * limits::max_place_candidates> candidates;
  std::size_t compared = 0;
  bool keeps = false;  ///< the search for features continues in the shared memory
  FixedVector<LinkRecord, static_cast<std::size_t>(limits::max_links_per_keyframe)> links;
  std::array<FixedVector<LinkPoint, limits::max_link_points>, static_cast<std::size_t>(limits::max_links_per_keyframe)>
      link_points{};  ///< points of each link
  Status drift;
  std::uint32_t known_before = 0;  ///< number of pixels that were removed from the mask
  std::size_t marked = 0;          ///< number of slices that have marked known ground, then of those that removed it
  bool mask_loaded = false;        ///< the image holds the mask
  bool mask_changed = false;
};
struct PlaceWorkspace {
  SeenCells seen, other_seen;
  CellDepths depths{};
  KnownGround known{};
  PlaceFeatures features, older;
  std::array<float, limits::max_place_features> feature_depths{}, older_depths{};
  PlacePatches patches, older_patches;
  PatchSightings sightings;
  PlaceMatch match;
  LinkMatches matches;
  FrameImage image;  ///< first the keyframe's image, then its mask
  std::array<std::uint8_t, max_mask_bytes(limits::max_image_pixels)> mask_bytes{};
  PlaceState after;
  // The memory of places, which follows from the records `place`.
  PlaceTable table;
  PlaceIndex index;
};

/// The inverse depth of the cell at a pixel; 0 where there is no ground.
[[nodiscard]] float depth_at(const CellDepths& depths, const SeenCells& cells, float x, float y);
/// Whether the values are possible for a pose. A pose with a flipped bit must not affect the masks of other keyframes.
[[nodiscard]] bool is_pose(const PoseRecord& pose);

class PlacePart {
 public:
  using Phase = PlacePhase;
  using Links = FixedVector<LinkRecord, static_cast<std::size_t>(limits::max_links_per_keyframe)>;
  using LinkPoints = FixedVector<LinkPoint, limits::max_link_points>;
  using Features = std::span<const PlaceFeature>;

  PlacePart(const PlaceWiring& wiring, const Cursor& cursor, PlaceWork& work, PlaceWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), work_(work), workspace_(workspace) {}

  /// Reads the pose of a keyframe, from its place if the pose record is gone.
  Status measured(std::int64_t keyframe_id, PoseRecord& pose);
  /// Whether the keyframe has a small overlap with the one before it, or no final pose.
  [[nodiscard]] bool weakly_connected() const;
  /// The first keyframe whose ground is in the coverage of the strip.
  [[nodiscard]] std::int64_t first_chained() const;
  /// The first keyframe with which this one is not compared, because their pairs connect them well.
  [[nodiscard]] std::int64_t first_too_recent() const;
  /// The number of features that the keyframe gets.
  [[nodiscard]] std::size_t features_wanted() const;

 protected:
  const PlaceWiring& wiring_;
  const Cursor& cursor_;
  PlaceWork& work_;
  PlaceWorkspace& workspace_;
};

}  // namespace ilp
