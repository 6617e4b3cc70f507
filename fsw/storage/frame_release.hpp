// Releases the images of frames that are no longer needed (decisions.md, 12).
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Images are released frame by frame in the order of ids. The image of a frame that is no keyframe is released once
/// the overlap checker has judged the frame, except images that the checker may still need: the frame of least overlap
/// since the last keyframe, and frames that do not match it. A keyframe's image is released when its products are made
/// and a newer keyframe exists.
struct FrameReleaseState {
  std::int64_t counted_id = 0;            ///< frames up to this one are in the account
  std::int64_t passed_id = 0;             ///< frames up to this one are released, held back, or keyframes
  std::int64_t passed_keyframe_id = 0;    ///< newest keyframe among the frames up to passed_id
  std::int64_t released_keyframe_id = 0;  ///< keyframes up to this one have no image any more
  std::int64_t best_id = 0;               ///< held back: frame of least overlap; 0: none
  double best_overlap = 0;                ///< overlap of that frame
  std::int64_t unrelated_id[2] = {};      ///< held back: first and latest frame that match nothing; 0: none
  std::int64_t thinned_id = 0;            ///< last frame that thin_frames() has examined
  std::uint32_t thinning = 0;  ///< 0: off; otherwise frames whose id is not a multiple of 2^thinning are released
};

/// Processes the next frame. Returns false if there is none.
using FrameReleaseStore = StorePart<Reads<KeyframeRecord, OverlapRecord>, Changes<FrameRecord>>;
Result<bool> release_frame(FrameReleaseStore store, FrameReleaseState& state, StorageRecord& account);

/// Processes the next keyframe. Returns false if there is none. `products_through` is the newest product.
Result<bool> release_keyframe_image(FrameReleaseStore store, std::int64_t products_through, FrameReleaseState& state,
                                    StorageRecord& account);

enum class Thinning : std::uint8_t {
  idle,       ///< nothing has changed
  begun,      ///< a period of thinning has begun
  under_way,  ///< the state has changed
};
/// Above `high_bytes` of frames, and until `low_bytes` are left, releases the image of one frame that the overlap
/// checker has not judged. Every other frame is released first, then further ones, so that the remaining frames are
/// evenly spaced.
Result<Thinning> thin_frames(FrameReleaseStore store, std::int64_t high_bytes, std::int64_t low_bytes,
                             FrameReleaseState& state, StorageRecord& account);

}  // namespace ilp
