// Corners of a keyframe and its matches to the previous keyframe, for every component that tracks points across
// keyframes.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "hal/camera/camera.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Megabytes of scratch. It carries nothing from step to step, so that all components that look for corners share one
/// object.
using FeatureScratch = FeatureOverlapWorkspace;

struct KeyframeImages {
  FrameImage current;
  FrameImage previous;           ///< the image that `current` is matched with
  std::int64_t previous_id = 0;  ///< its keyframe; 0: none is loaded
};

/// Loads the frame as the current image and finds its corners, as many as the level of reduced work allows.
Status find_corners(Reader<FrameRecord> store, const MissionParameters& mission, std::int64_t frame_id,
                    std::uint8_t level, FeatureScratch& scratch, KeyframeImages& images, Corners& corners);

/// Runs match_and_track_corners from keyframe `previous_id` to the current image. The keyframe's image is loaded only
/// if it is not in memory.
Status match_to_previous(Reader<KeyframeRecord, FrameRecord> store, const MissionParameters& mission,
                         std::int64_t previous_id, const Corners& previous_corners,
                         const double (&plane_from_previous)[9], FeatureScratch& scratch, KeyframeImages& images,
                         Corners& corners, Matches& matches);

/// Keeps the current image as that of the keyframe with which the next one is matched, so that it is not loaded again.
Status keep_for_next(std::int64_t keyframe_id, KeyframeImages& images);

}  // namespace ilp
