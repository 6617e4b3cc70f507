#include "fsw/motion/keyframe_features.hpp"

#include <cstring>

#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/work_level.hpp"

namespace ilp {

Status find_corners(Reader<FrameRecord> store, const MissionParameters& mission, std::int64_t frame_id,
                    std::uint8_t level, FeatureScratch& scratch, KeyframeImages& images, Corners& corners) {
  ILP_TRY(load_frame_image(store, frame_id, images.current));
  HarrisParams params;
  params.target_count = static_cast<std::int32_t>(corners_at(level, mission.corners));
  return detect_corners(images.current.view(), params, scratch.harris, corners);
}

Status match_to_previous(Reader<KeyframeRecord, FrameRecord> store, const MissionParameters& mission,
                         std::int64_t previous_id, const Corners& previous_corners,
                         const double (&plane_from_previous)[9], FeatureScratch& scratch, KeyframeImages& images,
                         Corners& corners, Matches& matches) {
  if (images.previous_id != previous_id) {
    images.previous_id = 0;
    ILP_TRY(load_keyframe_image(store, previous_id, images.previous));
    images.previous_id = previous_id;
  }
  MatcherParams params;
  params.search_radius_px = static_cast<float>(mission.search_radius_px);
  return match_and_track_corners(images.previous.view(), previous_corners, images.current.view(), corners,
                                 plane_from_previous, params, scratch.matcher, matches);
}

Status keep_for_next(std::int64_t keyframe_id, KeyframeImages& images) {
  ILP_TRY(images.previous.resize(images.current.width(), images.current.height()));
  const GrayView from = images.current.view();
  std::memcpy(images.previous.view().data, from.data, from.area());
  images.previous_id = keyframe_id;
  return {};
}

}  // namespace ilp
