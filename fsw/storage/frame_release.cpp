#include "fsw/storage/frame_release.hpp"

#include "fsw/shared/find.hpp"
#include "fsw/shared/valid_store.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t most_thinning = 6;
constexpr int frames_per_look = 64;

/// The bytes of the image that was taken.
Result<std::uint32_t> take_image(FrameReleaseStore store, std::int64_t frame_id, StorageRecord& account) {
  FrameRecord frame;
  ILP_TAKE(const bool found, find(store, frame_id, frame));
  const std::uint32_t bytes = found ? frame.image.bytes : 0;
  if (bytes == 0) return bytes;
  account.frame_bytes -= bytes;
  --account.frames_held;
  frame.image.bytes = 0;
  ILP_TRY(amend(store, frame));
  return bytes;
}

Status release_image(FrameReleaseStore store, std::int64_t frame_id, StorageRecord& account) {
  ILP_TAKE(const std::uint32_t bytes, take_image(store, frame_id, account));
  if (bytes != 0) ++account.frames_released;
  return {};
}

Status release_unrelated(FrameReleaseStore store, std::int64_t but_id, FrameReleaseState& state,
                         StorageRecord& account) {
  for (std::int64_t& id : state.unrelated_id) {
    if (id != 0 && id != but_id) ILP_TRY(release_image(store, id, account));
    id = 0;
  }
  return {};
}

Status release_held(FrameReleaseStore store, std::int64_t but_id, FrameReleaseState& state, StorageRecord& account) {
  if (state.best_id != 0 && state.best_id != but_id) ILP_TRY(release_image(store, state.best_id, account));
  state.best_id = 0;
  return release_unrelated(store, but_id, state, account);
}

Status hold_best(FrameReleaseStore store, const OverlapRecord& seen, FrameReleaseState& state, StorageRecord& account) {
  ILP_TRY(release_unrelated(store, 0, state, account));
  if (state.best_id != 0 && seen.overlap > state.best_overlap) return release_image(store, seen.id, account);
  if (state.best_id != 0) ILP_TRY(release_image(store, state.best_id, account));
  state.best_id = seen.id;
  state.best_overlap = seen.overlap;
  return {};
}

Status hold_unrelated(FrameReleaseStore store, std::int64_t frame_id, FrameReleaseState& state,
                      StorageRecord& account) {
  if (state.unrelated_id[0] == 0) {
    state.unrelated_id[0] = frame_id;
    return {};
  }
  // An unreadable frame is also recorded as unrelated, but only a truly unrelated one opens a strip.
  if (state.unrelated_id[1] != 0) ILP_TRY(release_image(store, state.unrelated_id[1], account));
  state.unrelated_id[1] = frame_id;
  return {};
}

/// Handles a frame after the newest keyframe, as the overlap checker judged it.
Status judge(FrameReleaseStore store, const OverlapRecord& seen, FrameReleaseState& state, StorageRecord& account) {
  switch (seen.decision) {
    case OverlapDecision::skipped:
      return hold_best(store, seen, state, account);
    case OverlapDecision::rejected:
      if (seen.verdict == OverlapVerdict::overlap_unknown) {
        return hold_unrelated(store, seen.id, state, account);
      }
      return release_image(store, seen.id, account);
    case OverlapDecision::burst:
      return release_image(store, seen.id, account);
    default:
      // It is a keyframe whose record is missing: it is kept.
      return {};
  }
}

}  // namespace

Result<bool> release_frame(FrameReleaseStore store, FrameReleaseState& state, StorageRecord& account) {
  KeyframeRecord keyframe;
  ILP_TAKE(const bool chosen, find_next_valid(store, state.passed_keyframe_id, keyframe));
  if (chosen && keyframe.frame_id <= state.passed_id) {
    // A held-back frame has become the keyframe.
    state.passed_keyframe_id = keyframe.id;
    ILP_TRY(release_held(store, keyframe.frame_id, state, account));
    return true;
  }
  const std::int64_t frame_id = state.passed_id + 1;
  if (frame_id > state.counted_id) return false;
  if (chosen && keyframe.frame_id > frame_id) {
    ILP_TRY(release_image(store, frame_id, account));
  } else if (chosen) {
    state.passed_keyframe_id = keyframe.id;
    ILP_TRY(release_held(store, 0, state, account));
  } else {
    OverlapRecord seen;
    const Status looked_at = get(store, frame_id, seen);
    if (looked_at.is(StatusCode::not_found)) return false;
    // The decision of a damaged one is not known: the image is kept.
    if (!looked_at.is(StatusCode::record_damaged)) {
      ILP_TRY(looked_at);
      ILP_TRY(judge(store, seen, state, account));
    }
  }
  state.passed_id = frame_id;
  return true;
}

Result<bool> release_keyframe_image(FrameReleaseStore store, std::int64_t products_through, FrameReleaseState& state,
                                    StorageRecord& account) {
  KeyframeRecord newest, keyframe;
  ILP_TAKE(const bool any, found_by(last(store, newest)));
  if (!any) return false;
  ILP_TAKE(const bool found, find_next_valid(store, state.released_keyframe_id, keyframe));
  // The overlap checker compares with the newest one.
  const bool needed = !found || keyframe.id >= newest.id || keyframe.id > state.passed_keyframe_id ||
                      products_through < product_id(keyframe.id, ProductKind::image);
  if (needed) return false;
  state.released_keyframe_id = keyframe.id;
  ILP_TRY(release_image(store, keyframe.frame_id, account));
  return true;
}

Result<Thinning> thin_frames(FrameReleaseStore store, std::int64_t high_bytes, std::int64_t low_bytes,
                             FrameReleaseState& state, StorageRecord& account) {
  if (state.thinning == 0 && account.frame_bytes <= high_bytes) return Thinning::idle;
  if (state.thinning != 0 && account.frame_bytes <= low_bytes) {
    state.thinning = 0;
    return Thinning::under_way;
  }
  std::int64_t seen_id = 0;
  ILP_TRY(newest_id<OverlapRecord>(store, seen_id));
  // The next one may be in work.
  const std::int64_t first = seen_id + 2;
  Thinning thinning = Thinning::idle;
  if (state.thinning == 0) {
    state.thinning = 1;
    state.thinned_id = 0;
    thinning = Thinning::begun;
  }
  if (state.thinned_id + 1 < first) state.thinned_id = first - 1;
  for (int looks = 0; looks < frames_per_look && state.thinned_id < state.counted_id; ++looks) {
    const std::int64_t frame_id = ++state.thinned_id;
    if (thinning == Thinning::idle) thinning = Thinning::under_way;
    if ((frame_id & ((std::int64_t{1} << state.thinning) - 1)) == 0) continue;
    ILP_TAKE(const std::uint32_t bytes, take_image(store, frame_id, account));
    if (bytes == 0) continue;
    ++account.frames_skipped;
    account.skipped_bytes += bytes;
    return thinning;
  }
  if (state.thinned_id >= state.counted_id && state.thinning < most_thinning && first <= state.counted_id) {
    ++state.thinning;
    state.thinned_id = first - 1;
    if (thinning == Thinning::idle) thinning = Thinning::under_way;
  }
  return thinning;
}

}  // namespace ilp
