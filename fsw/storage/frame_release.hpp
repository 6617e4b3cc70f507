// Decides when the image of a frame is no longer needed (decisions.md, 12).
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Images are released frame by frame in the order of ids. The image of a frame that was not chosen is released once
/// the overlap checker has judged the frame, except images that the checker may still need: the frame of least overlap
/// since the last keyframe, and frames unrelated to it. A keyframe's image is released when its products are made and a
/// newer keyframe exists.
struct FrameReleaseState {
  std::int64_t counted_id = 0;            ///< frames up to it are in the account
  std::int64_t passed_id = 0;             ///< frames up to it are released, held back, or keyframes
  std::int64_t passed_keyframe_id = 0;    ///< the newest keyframe among them
  std::int64_t released_keyframe_id = 0;  ///< keyframes up to it have no image any more
  std::int64_t best_id = 0;               ///< held back: frame of least overlap; 0: none
  double best_overlap = 0;
  std::int64_t unrelated_id[2] = {};  ///< held back: first and latest unrelated frame; 0: none
  std::int64_t thinned_id = 0;
  std::uint32_t thinning = 0;  ///< 0: off; else frames whose id 2^thinning does not divide are released
};

/// Advances by one frame, if there is one.
using FrameReleaseStore = StorePart<Reads<KeyframeRecord, OverlapRecord>, Changes<FrameRecord>>;
Result<bool> release_frame(FrameReleaseStore store, FrameReleaseState& state, StorageRecord& account);

/// Advances by one keyframe, if there is one; `products_through` is the newest product that has been made.
Result<bool> release_keyframe_image(FrameReleaseStore store, std::int64_t products_through, FrameReleaseState& state,
                                    StorageRecord& account);

enum class Thinning : std::uint8_t {
  idle,       ///< the state is as it was
  begun,      ///< the first release of a period
  under_way,  ///< the state has changed
};
/// Above `high_bytes` of frames, and until `low_bytes` are left, releases the image of one frame that the overlap
/// checker has not judged: every other one first, then more, so that the rest stays evenly spread.
Result<Thinning> thin_frames(FrameReleaseStore store, std::int64_t high_bytes, std::int64_t low_bytes,
                             FrameReleaseState& state, StorageRecord& account);

}  // namespace ilp
