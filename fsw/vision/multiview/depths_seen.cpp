#include "fsw/vision/multiview/depths_seen.hpp"

#include <algorithm>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

bool depths_seen(const SequenceState& s, const SequenceCamera& camera, FixedVector<float, limits::max_tracks>& scratch,
                 DepthsSeen& seen) {
  std::uint32_t ordinal = s.oldest;
  while (ordinal - s.oldest < s.cameras.size() && s.cameras[ordinal - s.oldest].keyframe_id != camera.keyframe_id) {
    ++ordinal;
  }
  const RigidTransform from_world = cam_from_world(camera.pose);
  scratch.clear();
  for (const Track& track : s.tracks) {
    const bool known = track.phase == TrackPhase::point || track.phase == TrackPhase::final_point;
    if (!known || !sees(track, ordinal)) continue;
    const double depth = (from_world * Vec3(track.position[0], track.position[1], track.position[2])).z();
    if (depth > 0 && !scratch.push_back(static_cast<float>(depth))) break;
  }
  if (scratch.size() < 10) return false;
  std::sort(scratch.begin(), scratch.end());
  const std::size_t margin = scratch.size() / 50;
  seen.least = static_cast<double>(scratch[margin]);
  seen.largest = static_cast<double>(scratch[scratch.size() - 1 - margin]);
  return true;
}

}  // namespace ilp
