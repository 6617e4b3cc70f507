// Detects the corners of a keyframe and matches them with the previous keyframe, in slices.
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

/// Scratch of several MB, which keeps the data of one search between its slices.
using FeatureScratch = FeatureOverlapWorkspace;

struct KeyframeImages {
  FrameImage current;
  FrameImage previous;           ///< the image with which `current` is matched
  std::int64_t previous_id = 0;  ///< keyframe of `previous`; 0: no image is loaded
};

/// Loads the frame as the current image, and begins the detection of its corners, as many as the work level allows. If
/// `shutter` has the image's motion, the image is corrected to the time of its middle row.
Status begin_corners_of(Reader<FrameRecord, CameraRecord> store, const MissionParameters& mission,
                        std::int64_t frame_id, std::uint8_t level, FeatureScratch& scratch, KeyframeImages& images,
                        Corners& corners, const ShutterRecord& shutter = {});
/// Runs a slice of detect_corners on the current image. Returns whether there is more to do.
Result<bool> find_corners(const MissionParameters& mission, std::uint8_t level, FeatureScratch& scratch,
                          const KeyframeImages& images, Corners& corners);

/// Begins match_and_track_corners from keyframe `previous_id` to the current image. The keyframe's image is loaded only
/// if it is not in memory.
Status begin_matches_to(Reader<KeyframeRecord, FrameRecord, CameraRecord, ShutterRecord> store,
                        const MissionParameters& mission, std::int64_t previous_id,
                        const double (&plane_from_previous)[9], FeatureScratch& scratch, KeyframeImages& images,
                        Matches& matches);
/// Runs a slice of match_and_track_corners. Returns whether there is more to do.
Result<bool> find_matches(const MissionParameters& mission, const Corners& previous_corners,
                          const double (&plane_from_previous)[9], FeatureScratch& scratch, const KeyframeImages& images,
                          Corners& corners, Matches& matches);

/// Adds the state of the search for corners, or for matches, in the shared memory to `memory` (LastingMemory::keeping).
[[nodiscard]] LastingMemory keeping_corners(const FeatureScratch& scratch, const LastingMemory& memory);
[[nodiscard]] LastingMemory keeping_matches(const FeatureScratch& scratch, const LastingMemory& memory);

/// Keeps the current image as `previous`, so that it need not be loaded again for the next keyframe.
Status keep_for_next(std::int64_t keyframe_id, KeyframeImages& images);

}  // namespace ilp
