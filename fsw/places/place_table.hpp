// The poses of the remembered keyframes, and the choice of the keyframe to forget when the memory of places is full.
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
  float centre[3] = {0, 0, 0};  ///< strip units
  float ground_distance = 0;    ///< median depth of the ground, strip units; 0: the keyframe has no pose in its strip
  std::uint16_t before = 0;     ///< slot of the remembered keyframe before this one, + 1; 0: none
  std::uint16_t after = 0;      ///< slot of the remembered keyframe after this one, + 1; 0: none
  bool seen_again = false;      ///< it is linked to an earlier keyframe
};

/// A candidate from its position: its ground is expected in the image of another keyframe.
struct NearPlace {
  std::uint16_t slot = 0;
  double distance = 0;  ///< between both image centres on the ground, divided by half the shorter image side there
};
using NearPlaces = FixedVector<NearPlace, limits::max_near_places>;

/// The pose of a place.
[[nodiscard]] RigidTransform camera_at(const RememberedPlace& place);

/// The ground at the centre of its image, in its strip's world frame.
[[nodiscard]] Vec3 ground_of(const RememberedPlace& place);

/// The remembered keyframes. Their slots do not affect results. Keyframes are added in ascending order of ids.
class PlaceTable {
 public:
  /// The first slots are never forgotten, because the vocabulary of the index is made from them.
  static constexpr std::size_t kept_for_ever = limits::place_vocabulary_places;

  void clear();
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const RememberedPlace& at(std::size_t slot) const { return places_[slot]; }

  /// Adds the newest keyframe. Returns false if the slot is used or out of range, or if the keyframe is not the newest.
  [[nodiscard]] bool add(std::size_t slot, const RememberedPlace& place);
  void remove(std::size_t slot);

  /// The slot of the keyframe with the least need, which is to be forgotten. The need is the distance between the
  /// keyframes before and after it in its strip, divided by the distance of the ground; it is 1 at the end of a strip,
  /// 0 without a pose in a strip, and halved for a keyframe that is linked to an earlier one. The newest keyframe and
  /// the first `kept_for_ever` slots are never chosen. Returns limits::max_places if there is no other keyframe.
  [[nodiscard]] std::size_t least_needed() const;

  /// Finds the places of one strip, with ids up to `through_id`, whose ground a given camera sees: those with the
  /// smallest distances below `farthest`. The camera is given by its frame from the strip's world frame and by the
  /// depth of the ground, strip units. The distances of the ground from both cameras must differ by at most a factor of
  /// two.
  void find_near(std::int64_t strip_id, std::int64_t through_id, const Similarity& cam_from_world,
                 double ground_distance, double farthest, const CameraModel& camera, NearPlaces& near) const;

  /// The newest keyframe; the null pointer if there is none.
  [[nodiscard]] const RememberedPlace* newest() const;
  /// The slots of the newest keyframe and of the remembered one before it; limits::max_places if there is none.
  [[nodiscard]] std::array<std::size_t, 2> newest_slots() const;

 private:
  /// Whether `number`, a slot + 1, refers to a slot. A flipped bit never leads out of range.
  [[nodiscard]] static bool known(std::uint16_t number) { return number != 0 && number <= limits::max_places; }
  [[nodiscard]] double need(const RememberedPlace& place) const;

  std::array<RememberedPlace, limits::max_places> places_{};
  std::size_t count_ = 0;
  std::uint16_t newest_ = 0;  ///< slot + 1
};

}  // namespace ilp
