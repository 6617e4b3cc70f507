#include "fsw/storage/storage_release.hpp"

#include "fsw/shared/find.hpp"

namespace ilp {
namespace {

// The check of a strip against the camera looks at points of its first or last keyframes, and their windows.
constexpr std::int64_t keyframes_with_points = 100;

}  // namespace

/// Where none can be read, there is nothing to release, and nothing changes any more.
Status StorageRelease::find_mask(std::int64_t keyframe_id, MaskRecord& mask) {
  ILP_TAKE(const bool found, find(wiring_.store, keyframe_id, mask));
  if (!found) mask.scope = MaskScope::flight;
  return {};
}

Status StorageRelease::release_depth(Draft& draft) {
  State& after = draft.after;
  DepthRecord depth;
  ILP_TAKE(const bool found, find_next_valid(wiring_.store, after.coded_depth_id, depth));
  // The image of a keyframe is coded after its depth map.
  if (found && depth.id <= after.counted_depth_id &&
      after.counted_product_id >= product_id(depth.id, ProductKind::image)) {
    after.coded_depth_id = depth.id;
    const std::int64_t coded_bytes = std::int64_t{depth.values.bytes} + depth.sigma.bytes + depth.cells.bytes;
    MaskRecord mask;
    ILP_TRY(find_mask(depth.id, mask));
    after.account.depth_bytes -= coded_bytes;
    if (coded_bytes != 0 && mask.code.bytes == 0) --after.account.depths_held;
    depth.values.bytes = 0;
    depth.sigma.bytes = 0;
    depth.cells.bytes = 0;
    draft.changed = true;
    ILP_TRY(amend(wiring_.store, depth));
  }
  return {};
}

Status StorageRelease::release_mask(MaskRecord mask, Draft& draft) {
  draft.after.account.depth_bytes -= mask.code.bytes;
  --draft.after.account.depths_held;
  mask.code.bytes = 0;
  draft.changed = true;
  return amend(wiring_.store, mask);
}

Status StorageRelease::release_points(StructureRecord structure, bool held, Draft& draft) {
  StorageRecord& account = draft.after.account;
  account.structure_bytes -= structure.points.bytes;
  --account.structures_held;
  if (!held) ++account.structures_dropped;
  if (!held) account.dropped_bytes += structure.points.bytes;
  structure.points.bytes = 0;
  draft.changed = true;
  return amend(wiring_.store, structure);
}

Status StorageRelease::age_points(Draft& draft) {
  State& after = draft.after;
  StructureRecord structure;
  ILP_TAKE(const bool found, find_next_valid(wiring_.store, after.aged_structure_id, structure));
  if (!found || structure.id > after.counted_structure_id ||
      structure.id > after.frames.passed_keyframe_id - keyframes_with_points) {
    return {};
  }
  // The window of bits moves on; the skipped ones belong to keyframes without points.
  bool held = false;
  for (; after.aged_structure_id < structure.id; ++after.aged_structure_id) {
    held = (after.points_held[0] & 1U) != 0;
    bool any = false;
    for (std::size_t i = 0; i < after.points_held.size(); ++i) {
      any = any || after.points_held[i] != 0;
      const std::uint64_t next = i + 1 < after.points_held.size() ? after.points_held[i + 1] : 0;
      after.points_held[i] = (after.points_held[i] >> 1U) | (next << 63U);
    }
    // Ids of a later store epoch begin far after this: no bit is left to be moved.
    if (!any) after.aged_structure_id = structure.id - 1;
  }
  draft.changed = true;
  return held && structure.points.bytes != 0 ? release_points(structure, true, draft) : Status{};
}

Result<std::int64_t> StorageRelease::unneeded_before() {
  // For as long as records without a confirmation stay: record_history.hpp.
  KeyframeRecord newest;
  ILP_TAKE(const bool any, found_by(last(wiring_.store, newest)));
  return any ? newest.id - unconfirmed_factor * wiring_.mission.history_keyframes : std::int64_t{0};
}

Result<bool> StorageRelease::release_oldest_points(bool full, Draft& draft) {
  State& after = draft.after;
  ILP_TAKE(const std::int64_t unneeded, unneeded_before());
  for (int i = 0; i < batch; ++i) {
    StructureRecord structure;
    ILP_TAKE(const bool found, find_next_valid(wiring_.store, after.released_structure_id, structure));
    if (!found || structure.id > after.aged_structure_id) return false;
    const bool held = structure.points.bytes != 0;
    if (held && !full && structure.id > unneeded) return false;
    after.released_structure_id = structure.id;
    draft.changed = true;
    if (!held) continue;
    ILP_TRY(release_points(structure, false, draft));
    return true;
  }
  return false;
}

Result<bool> StorageRelease::release_oldest_mask(bool full, Draft& draft) {
  State& after = draft.after;
  ILP_TAKE(std::int64_t unneeded, unneeded_before());
  // The newest file shows how far records were sent.
  DownlinkRecord sent;
  if (full) ILP_TRY(found_by(last(wiring_.store, sent)).status());
  if (sent.records_through > unneeded) unneeded = sent.records_through;
  for (int i = 0; i < batch; ++i) {
    MaskRecord mask;
    ILP_TAKE(const bool found, find_next_valid(wiring_.store, after.released_depth_id, mask));
    if (!found || mask.id > after.coded_depth_id) return false;
    if (mask.code.bytes != 0 && mask.id > unneeded) return false;
    after.released_depth_id = mask.id;
    draft.changed = true;
    if (mask.code.bytes == 0) continue;
    after.account.dropped_bytes += mask.code.bytes;
    ILP_TRY(release_mask(mask, draft));
    return true;
  }
  return false;
}

Status StorageRelease::release(Draft& draft) {
  State& after = draft.after;
  ILP_TAKE(const bool passed, release_frame(wiring_.store, after.frames, after.account));
  ILP_TAKE(const bool released,
           release_keyframe_image(wiring_.store, after.counted_product_id, after.frames, after.account));
  draft.changed = draft.changed || passed || released;
  ILP_TRY(release_depth(draft));
  return age_points(draft);
}

Result<bool> StorageRelease::finish_records(const DownlinkRecord& sent, Draft& draft) {
  MaskRecord mask;
  ILP_TAKE(const bool found, find(wiring_.store, sent.subject_id, mask));
  if (!found) return true;
  if (mask.id > draft.after.coded_depth_id) return false;
  if (mask.code.bytes != 0) ILP_TRY(release_mask(mask, draft));
  return true;
}

Result<bool> StorageRelease::finish_points(const DownlinkRecord& sent, Draft& draft) {
  State& after = draft.after;
  const std::int64_t place = sent.subject_id - after.aged_structure_id - 1;
  if (place >= points_window) return false;
  if (place >= 0) {
    std::uint64_t& bits = after.points_held[static_cast<std::size_t>(place / 64)];
    const std::uint64_t bit = std::uint64_t{1} << static_cast<unsigned>(place % 64);
    draft.changed = draft.changed || (bits & bit) == 0;
    bits |= bit;
    return true;
  }
  StructureRecord structure;
  ILP_TAKE(const bool found, find(wiring_.store, sent.subject_id, structure));
  if (found && structure.points.bytes != 0) ILP_TRY(release_points(structure, true, draft));
  return true;
}

}  // namespace ilp
