// Knows ground again that an earlier keyframe of the flight has seen: Depth -> Place, Link, Tie, and the mask of new
// ground (docs/one-map.md).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/places/known_ground.hpp"
#include "fsw/places/place_table.hpp"
#include "fsw/places/strip_tie.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/vision/multiview/link_geometry.hpp"
#include "fsw/vision/place/place_index.hpp"
#include "fsw/vision/place/place_patches.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "fsw/vision/place/place_verification.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// Every keyframe with a depth record gets a place, in the order of keyframes. First its features are compared with
/// those of earlier keyframes: of those that stand near it in what is tied together, and of those that look like it.
/// A keyframe that shows the same ground gets a link. Where links or strips lead to keyframes that have seen ground at
/// least as well, it leaves the mask of new ground. A keyframe whose image or maps cannot be read gets a place without
/// features, and its mask stays as it is. After a start the places on record are read into memory before the next
/// keyframe. A place that cannot be read then is erased. There are never more than have room (place_room.hpp).
class PlaceMemory final : public StageComponent<ComponentId::place_memory> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = StepScratch<PlaceScratch, PlaceQueryWorkspace, LinkGeometryWorkspace>;

  PlaceMemory(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override;

 private:
  /// Keyframes of a strip that the chain of pairs relates to each other, and whose ground its coverage knows.
  static constexpr std::int64_t chained_keyframes = 8;

  enum class Phase : std::uint8_t { recall, idle, load, features, patches, search, compare, narrow, cut, record };

  struct Wiring {
    Tables store;
    const MissionParameters& mission;
    Scratch scratch;
  };
  struct State {
    std::int64_t bare_id = 0;  ///< newest place without features: its record goes with the next one
    StripLinks links;          ///< of the newest strip
  };
  using Links = FixedVector<LinkRecord, static_cast<std::size_t>(limits::max_links_per_keyframe)>;
  using LinkPoints = FixedVector<LinkPoint, limits::max_link_points>;
  using Features = std::span<const PlaceFeature>;
  struct Work {
    Patience patience;
    CameraModel camera;
    // The keyframe at work; a restart drops it.
    Phase phase = Phase::recall;
    std::int64_t recalled_id = 0;
    DepthRecord depth;
    MaskRecord mask;  ///< id 0: it is gone
    KeyframeRecord keyframe;
    PoseRecord pose;
    double ground_distance = 0;
    FixedVector<std::uint16_t, 3 * limits::max_place_candidates> candidates;
    std::size_t compared = 0;
    bool keeps = false;  ///< the search for features goes on in the step's memory
    Links links;
    std::array<LinkPoints, static_cast<std::size_t>(limits::max_links_per_keyframe)> link_points{};  ///< of each link
    Status drift;
    std::uint32_t known_before = 0;  ///< pixels that leave the mask
    std::size_t marked = 0;          ///< slices that have marked known ground, then those that have cut it out
    bool mask_loaded = false;        ///< the image holds the mask
    bool mask_changed = false;
  };
  struct Workspace {
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
    State after;
    // What is remembered: all of it follows from the records `place`.
    PlaceTable table;
    PlaceIndex index;
  };

  Status advance(bool& picked);
  Status recall();
  Status recall_place(const PlaceRecord& place, bool& sound);
  void fill_vocabulary(std::size_t through_slot);
  Status newest_place(std::int64_t& id);
  Status erase_place(std::int64_t id);
  Status forget_one(bool& forgotten);
  Status pick(bool& picked);
  Status load();
  Status find_features();
  Status take_patches();
  Status search();
  Status compare();
  Status load_features(const PlaceRecord& place, bool& sound);
  Status link_with(const RememberedPlace& place, const PlaceRecord& record);
  void match_features();
  void match_patches();
  void add_match(float older_x, float older_y, float older_depth, float x, float y);
  Status relate(std::uint64_t link_id, LinkGeometry& geometry);
  Status register_patches(const PlaceRecord& place, LinkPoints& points);
  Status record();

  Status load_cells();
  void give_depths();
  [[nodiscard]] std::size_t features_wanted() const;
  Status tied_to(std::int64_t strip_id, bool& tied, TieRecord& tie) const;
  template <typename Places>
  void add_candidates(const Places& places);
  void add_candidate(std::size_t slot);
  [[nodiscard]] bool loosely_chained() const;
  [[nodiscard]] std::int64_t first_chained() const;
  [[nodiscard]] std::int64_t first_too_recent() const;
  Status measured(std::int64_t keyframe_id, PoseRecord& pose);
  void judge(LinkRecord& link, const PoseRecord& place);
  Status load_mask();
  /// Each of these marks by one keyframe, the first after `left` of those that count; then `done` is set.
  Status mark_by(const LinkRecord& link, std::size_t& left, bool& done);
  Status mark_by_poses(std::size_t& left, bool& done);
  Status mark_by_links_before(std::size_t& left, bool& done);
  Status mark_by_link_of(std::int64_t linked_id, const LinkRecord& link, std::size_t& left, bool& done);
  Status link_before(std::int64_t keyframe_id, std::int64_t number, LinkRecord& link, bool& found);
  Status mark_next(bool& done);
  Status mark_seen_by(const NearPlace& near, const Similarity& cam_from_strip, double error_px);
  [[nodiscard]] Vec3 ground_here() const;
  [[nodiscard]] bool comes_back_to(const RememberedPlace& place, const RememberedPlace& before) const;
  [[nodiscard]] bool lies_inside(const RememberedPlace& before) const;
  Status error_by_poses(const RememberedPlace& place, double& error_px);
  Status load_seen(std::int64_t keyframe_id, SeenCells& cells);
  Status mark_known_ground();
  Status cut_mask();
  Status choose_slot(PlaceRecord& place, std::size_t& forgotten);
  Status write_place(const PlaceRecord& place, std::size_t forgotten);
  Status write_ties(State& after);
  void remember(const PlaceRecord& place, std::size_t forgotten);
  static RememberedPlace entry_of(const PlaceRecord& place);

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
