// Corners of a keyframe and its matches to the previous keyframe, for every component that tracks points across
// keyframes.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "hal/camera/camera.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Megabytes of scratch, which hold what the slices of one search share.
using FeatureScratch = FeatureOverlapWorkspace;

struct KeyframeImages {
  FrameImage current;
  FrameImage previous;           ///< the image that `current` is matched with
  std::int64_t previous_id = 0;  ///< its keyframe; 0: none is loaded
};

/// Loads the frame as the current image, at the time of its middle row where `shutter` says how it moves, and begins to
/// look for its corners, as many as the level of reduced work allows.
Status begin_corners_of(Reader<FrameRecord, CameraRecord> store, const MissionParameters& mission,
                        std::int64_t frame_id, std::uint8_t level, FeatureScratch& scratch, KeyframeImages& images,
                        Corners& corners, const ShutterRecord& shutter = {});
/// A slice of detect_corners on the current image; whether there is more to do.
Result<bool> find_corners(const MissionParameters& mission, std::uint8_t level, FeatureScratch& scratch,
                          const KeyframeImages& images, Corners& corners);

/// Begins match_and_track_corners from keyframe `previous_id` to the current image. The keyframe's image is loaded only
/// if it is not in memory.
Status begin_matches_to(Reader<KeyframeRecord, FrameRecord, CameraRecord, ShutterRecord> store,
                        const MissionParameters& mission, std::int64_t previous_id,
                        const double (&plane_from_previous)[9], FeatureScratch& scratch, KeyframeImages& images,
                        Matches& matches);
/// A slice of it.
Result<bool> find_matches(const MissionParameters& mission, const Corners& previous_corners,
                          const double (&plane_from_previous)[9], FeatureScratch& scratch, const KeyframeImages& images,
                          Corners& corners, Matches& matches);

/// Adds where the search for corners, or for matches, is in the memory of the step.
[[nodiscard]] LastingMemory keeping_corners(const FeatureScratch& scratch, const LastingMemory& memory);
[[nodiscard]] LastingMemory keeping_matches(const FeatureScratch& scratch, const LastingMemory& memory);

/// Keeps the current image as that of the keyframe with which the next one is matched, so that it is not loaded again.
Status keep_for_next(std::int64_t keyframe_id, KeyframeImages& images);

}  // namespace ilp
