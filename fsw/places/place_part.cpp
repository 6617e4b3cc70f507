#include "fsw/places/place_part.hpp"

#include <algorithm>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// Overlap from which the chain determines a keyframe's pose well.
constexpr double closely_chained = 0.7;

}  // namespace

float depth_at(const CellDepths& depths, const SeenCells& cells, float x, float y) {
  const auto column = static_cast<std::int32_t>(x) / seen_cell_px;
  const auto row = static_cast<std::int32_t>(y) / seen_cell_px;
  if (column < 0 || row < 0 || column >= cells.columns || row >= cells.rows) return 0;
  return depths[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells.columns) +
                static_cast<std::size_t>(column)];
}

bool is_pose(const PoseRecord& pose) {
  const RigidTransform camera = cam_from_world(pose_of(pose));
  return camera.rotation.allFinite() && camera.translation.allFinite();
}

/// The pose of an earlier keyframe; without its errors when its own record was erased with the history, and not final
/// when neither record can be read.
Status PlacePart::measured(std::int64_t keyframe_id, PoseRecord& pose) {
  ILP_TAKE(const bool found, find(wiring_.store, keyframe_id, pose));
  if (!found) {
    PlaceRecord place;
    ILP_TAKE(const bool kept, find(wiring_.store, keyframe_id, place));
    pose = {};
    pose.id = place.id;
    pose.strip_id = place.strip_id;
    pose.state = kept && place.posed ? PoseState::final : PoseState::failed;
    std::copy_n(place.q_cam_from_world, 4, pose.q_cam_from_world);
    std::copy_n(place.centre, 3, pose.centre);
  }
  if (!is_pose(pose)) pose.state = PoseState::failed;
  return {};
}

/// Whether the chain of pairs says little about this keyframe: it begins a strip, shares less than planned with the
/// keyframe before it, or has no pose.
bool PlacePart::weakly_connected() const {
  return !(work_.keyframe.overlap >= closely_chained) || work_.pose.state != PoseState::final;
}

/// The first keyframe whose ground the coverage of this strip knows.
std::int64_t PlacePart::first_chained() const {
  return std::max(work_.keyframe.id - work_.keyframe.index, work_.keyframe.id - chained_keyframes + 1);
}

/// The first keyframe that is not compared: the chain of this strip relates them.
std::int64_t PlacePart::first_too_recent() const {
  return weakly_connected() ? work_.keyframe.id : first_chained();
}

std::size_t PlacePart::features_wanted() const {
  return weakly_connected() ? limits::max_place_features : limits::place_features;
}

}  // namespace ilp
