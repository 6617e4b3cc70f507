#include "fsw/motion/keyframe_features.hpp"

#include <cstring>

#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/work_level.hpp"

namespace ilp {
namespace {

HarrisParams harris_params(const MissionParameters& mission, std::uint8_t level) {
  HarrisParams params;
  params.target_count = static_cast<std::int32_t>(corners_at(level, mission.corners));
  return params;
}

MatcherParams matcher_params(const MissionParameters& mission) {
  MatcherParams params;
  params.search_radius_px = static_cast<float>(mission.search_radius_px);
  return params;
}

}  // namespace

Status begin_corners_of(Reader<FrameRecord, CameraRecord> store, const MissionParameters& mission,
                        std::int64_t frame_id, std::uint8_t level, FeatureScratch& scratch, KeyframeImages& images,
                        Corners& corners, const ShutterRecord& shutter) {
  ILP_TRY(load_frame_image(store, frame_id, images.current));
  if (shutter.source != MotionSource::none) {
    CameraModel camera;
    ILP_TRY(load_camera(store, camera));
    ILP_TRY(bring_to_middle_row(camera, shutter, images.current).status());
  }
  return begin_corners(images.current.view(), harris_params(mission, level), scratch.harris, corners);
}

Result<bool> find_corners(const MissionParameters& mission, std::uint8_t level, FeatureScratch& scratch,
                          const KeyframeImages& images, Corners& corners) {
  return detect_corners_slice(images.current.view(), harris_params(mission, level), scratch.harris, corners);
}

Status begin_matches_to(Reader<KeyframeRecord, FrameRecord, CameraRecord, ShutterRecord> store,
                        const MissionParameters& mission, std::int64_t previous_id,
                        const double (&plane_from_previous)[9], FeatureScratch& scratch, KeyframeImages& images,
                        Matches& matches) {
  if (images.previous_id != previous_id) {
    images.previous_id = 0;
    ILP_TRY(load_keyframe_image(store, previous_id, images.previous));
    images.previous_id = previous_id;
  }
  return begin_matching(images.previous.view(), images.current.view(), plane_from_previous, matcher_params(mission),
                        scratch.matcher, matches);
}

Result<bool> find_matches(const MissionParameters& mission, const Corners& previous_corners,
                          const double (&plane_from_previous)[9], FeatureScratch& scratch, const KeyframeImages& images,
                          Corners& corners, Matches& matches) {
  return match_and_track_slice(images.previous.view(), previous_corners, images.current.view(), corners,
                               plane_from_previous, matcher_params(mission), scratch.matcher, matches);
}

LastingMemory keeping_corners(const FeatureScratch& scratch, const LastingMemory& memory) {
  return memory.keeping(scratch.harris.progress);
}

LastingMemory keeping_matches(const FeatureScratch& scratch, const LastingMemory& memory) {
  return memory.keeping(scratch.matcher.progress);
}

Status keep_for_next(std::int64_t keyframe_id, KeyframeImages& images) {
  ILP_TRY(images.previous.resize(images.current.width(), images.current.height()));
  const GrayView from = images.current.view();
  std::memcpy(images.previous.view().data, from.data, from.area());
  images.previous_id = keyframe_id;
  return {};
}

}  // namespace ilp
