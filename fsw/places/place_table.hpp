// Where the remembered keyframes stand, and which of them is forgotten when the memory of places is full.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/similarity.hpp"

namespace ilp {

/// A remembered keyframe.
struct RememberedPlace {
  std::int64_t keyframe_id = 0;  ///< 0: the slot is free
  std::int64_t strip_id = 0;
  float q_cam_from_world[4] = {1, 0, 0, 0};
  float centre[3] = {0, 0, 0};  ///< strip unit
  float ground_distance = 0;    ///< median depth of the ground, strip unit; 0: the keyframe has no place in its strip
  std::uint16_t before = 0;     ///< slot of the remembered keyframe before it, + 1; 0: none
  std::uint16_t after = 0;      ///< slot of the one after it, + 1; 0: none
  bool seen_again = false;      ///< it is linked to an earlier keyframe
};

/// A candidate by its place: its ground is expected in the image of another keyframe.
struct NearPlace {
  std::uint16_t slot = 0;
  double distance = 0;  ///< of the middles of both images on the ground, divided by half the shorter side there
};
using NearPlaces = FixedVector<NearPlace, limits::max_near_places>;

[[nodiscard]] RigidTransform camera_at(const RememberedPlace& place);

/// The ground in the middle of its image, in its strip's world.
[[nodiscard]] Vec3 ground_of(const RememberedPlace& place);

/// The content depends only on the places that were added and removed last, not on the order of slots. Keyframes are
/// added in the order of their numbers.
class PlaceTable {
 public:
  /// The first slots are never forgotten, because the vocabulary of the index is made from them.
  static constexpr std::size_t kept_for_ever = limits::place_vocabulary_places;

  void clear();
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const RememberedPlace& at(std::size_t slot) const { return places_[slot]; }

  /// Adds the newest keyframe. False if the slot is taken or outside the memory, or the keyframe is not the newest.
  [[nodiscard]] bool add(std::size_t slot, const RememberedPlace& place);
  void remove(std::size_t slot);

  /// The slot whose ground its neighbours show best: the keyframes before and after it in its strip are nearest to each
  /// other, as a share of their distance from the ground; ground that was linked to earlier ground counts half. A
  /// keyframe at the end of a strip is worth as much as one between two that are one distance apart. One without a
  /// place in a strip is forgotten before all others. Never the newest keyframe; limits::max_places if there is none.
  [[nodiscard]] std::size_t least_needed() const;

  /// Places of one strip up to `through_id`, those with the smallest distances below `farthest`, whose ground a camera
  /// sees that stands in the world of that strip: its frame from that world, and the depth of the ground before it. The
  /// ground must be at most twice as far from one camera as from the other.
  void find_near(std::int64_t strip_id, std::int64_t through_id, const Similarity& cam_from_world,
                 double ground_distance, double farthest, const CameraModel& camera, NearPlaces& near) const;

  /// The newest keyframe; the null pointer if there is none.
  [[nodiscard]] const RememberedPlace* newest() const;
  /// The slots of the newest keyframe and of the one that is remembered before it; limits::max_places if there is none.
  [[nodiscard]] std::array<std::size_t, 2> newest_slots() const;

 private:
  /// The number of a slot, + 1. A flipped bit never leads beyond the slots.
  [[nodiscard]] static bool known(std::uint16_t number) { return number != 0 && number <= limits::max_places; }
  [[nodiscard]] double need(const RememberedPlace& place) const;

  std::array<RememberedPlace, limits::max_places> places_{};
  std::size_t count_ = 0;
  std::uint16_t newest_ = 0;  ///< slot + 1
};

}  // namespace ilp
