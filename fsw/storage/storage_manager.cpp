#include "fsw/storage/storage_manager.hpp"

#include "fsw/shared/find.hpp"
#include "fsw/shared/place_capacity.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int files_per_step = 64;

std::int64_t blob_bytes(const FrameRecord& frame) {
  return frame.image.bytes;
}
std::int64_t blob_bytes(const DepthRecord& depth) {
  return std::int64_t{depth.values.bytes} + depth.sigma.bytes + depth.cells.bytes;
}
std::int64_t blob_bytes(const StructureRecord& structure) {
  return structure.points.bytes;
}
std::int64_t blob_bytes(const ProductRecord& product) {
  return product.data.bytes;
}

/// Takes the next record into the account.
template <typename Record>
Status count_next(StorageDraft& draft, Reader<Record> store, std::int64_t& counted_id, std::int64_t& bytes,
                  std::uint32_t& held) {
  Record record;
  ILP_TAKE(const bool found, find_next_valid(store, counted_id, record));
  if (!found) return {};
  counted_id = record.id;
  bytes += blob_bytes(record);
  if (blob_bytes(record) != 0) ++held;
  draft.changed = true;
  return {};
}

/// Poses by a camera that is still looked for are made again, and their points with them.
Result<bool> is_trial(Reader<StructureRecord, PoseRecord> store, std::int64_t after) {
  StructureRecord structure;
  PoseRecord pose;
  ILP_TAKE(const bool any, find_next_valid(store, after, structure));
  if (!any) return false;
  ILP_TAKE(const bool known, find(store, structure.id, pose));
  return known && is_open(pose.state);
}

}  // namespace

constexpr CheckpointForm StorageManager::checkpoint = checkpoint_form<State>(component_id);

StorageManager::StorageManager(Tables store, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, ValidView<Tables::tables>(store), mission, scratch} {}

Status StorageManager::restore() {
  work_.search.restart();
  work_.searching = false;
  work_.has_abandoned = false;
  work_.rounds_done = work_.searches_done = false;
  work_.asked_id = 0;
  work_.swept_id = 0;
  work_.weighed = false;
  const Status status = restore_checkpoint(wiring_.whole, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  // Without a checkpoint the totals on record stay.
  if (!status.ok() || state_.frames.counted_id == 0) ILP_TRY(recount());
  begin_ids<FrameRecord>(wiring_.store, state_.frames.passed_id);
  begin_ids<FrameRecord>(wiring_.store, state_.frames.counted_id);
  return status;
}

/// An account that is older than the records would stay wrong: held records are counted again, totals stay.
Status StorageManager::recount() {
  StorageRecord known;
  ILP_TAKE(const bool found, find(wiring_.store, known.id, known));
  if (!found) known = {};
  known.frame_bytes = known.depth_bytes = known.structure_bytes = known.product_bytes = 0;
  known.frames_held = known.depths_held = known.structures_held = known.products_held = 0;
  state_ = {};
  state_.account = known;
  return {};
}

/// Counting takes time in proportion to the places, whose number changes when a new one comes.
Status StorageManager::weigh_places() {
  std::int64_t newest = 0;
  ILP_TRY(newest_id<PlaceRecord>(wiring_.store, newest));
  if (work_.weighed && newest == work_.weighed_id) return {};
  std::int64_t places = 0;
  ILP_TRY(wiring_.store.count<PlaceRecord>(places));
  work_.place_bytes = places * most_place_bytes;
  work_.weighed = true;
  work_.weighed_id = newest;
  return {};
}

/// A depth map and its mask, once that is final.
Status StorageManager::count_depth(Draft& draft) {
  State& after = draft.after;
  DepthRecord depth;
  ILP_TAKE(const bool found, find_next_valid(wiring_.store, after.counted_depth_id, depth));
  if (!found) return {};
  MaskRecord mask;
  ILP_TRY(release_part().find_mask(depth.id, mask));
  if (mask.scope != MaskScope::flight) return {};
  after.counted_depth_id = depth.id;
  const std::int64_t bytes = blob_bytes(depth) + mask.code.bytes;
  after.account.depth_bytes += bytes;
  if (bytes != 0) ++after.account.depths_held;
  draft.changed = true;
  return {};
}

Status StorageManager::count_new(Draft& draft) {
  State& after = draft.after;
  StorageRecord& account = after.account;
  ILP_TRY(
      count_next<FrameRecord>(draft, wiring_.store, after.frames.counted_id, account.frame_bytes, account.frames_held));
  ILP_TRY(count_depth(draft));
  ILP_TAKE(const bool made_again, is_trial(wiring_.store, after.counted_structure_id));
  if (!made_again) {
    ILP_TRY(count_next<StructureRecord>(draft, wiring_.store, after.counted_structure_id, account.structure_bytes,
                                        account.structures_held));
  }
  return count_next<ProductRecord>(draft, wiring_.store, after.counted_product_id, account.product_bytes,
                                   account.products_held);
}

Status StorageManager::obey_commands(Draft& draft) {
  // Bounded by the number of commands; one product a step.
  for (bool dropped = false; !dropped;) {
    CommandRecord command;
    ILP_TAKE(const bool any, find_next_valid(wiring_.store, draft.after.obeyed_command_id, command));
    if (!any) return {};
    if (command.kind == CommandKind::delete_product) {
      ProductRecord product;
      ILP_TAKE(const bool held, find(wiring_.store, command.subject_id, product));
      // Products that have not been counted yet are deleted after they are counted.
      if (held && product.id > draft.after.counted_product_id) return {};
      dropped = held && product.data.bytes != 0;
      if (dropped) ILP_TRY(products().drop(product, draft));
    }
    draft.after.obeyed_command_id = command.id;
    draft.changed = true;
  }
  return {};
}

Status StorageManager::delete_acknowledged(Draft& draft) {
  State& after = draft.after;
  if (work_.asked_id < after.checked_downlink_id) work_.asked_id = after.checked_downlink_id;
  bool all_before = work_.asked_id == after.checked_downlink_id;
  work_.round_done = false;
  DownlinkRecord newest;
  ILP_TRY(found_by(last(wiring_.store, newest)).status());
  for (int asked = 0; asked < files_per_step; ++asked) {
    DownlinkRecord sent;
    ILP_TAKE(const bool found, find_next_valid(wiring_.store, work_.asked_id, sent));
    if (!found) {
      // In turns over all files, so that a missing confirmation does not delay those after it.
      work_.asked_id = 0;
      work_.round_done = true;
      return {};
    }
    work_.asked_id = sent.id;
    ILP_TAKE(const bool confirmed, release_confirmed(sent, newest.sent_ns, draft));
    all_before = all_before && confirmed;
    if (all_before) {
      after.checked_downlink_id = sent.id;
      draft.changed = true;
    }
  }
  return {};
}

Result<bool> StorageManager::release_confirmed(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft) {
  const bool confirmed = sent.acknowledged_ns != 0;
  if (sent.kind == DownlinkKind::product) {
    ILP_TRY(products().finish_product(sent, newest_sent_ns, draft));
  } else if (confirmed && sent.kind == DownlinkKind::points) {
    return release_part().finish_points(sent, draft);
  } else if (confirmed && sent.subject_id > 0) {
    return release_part().finish_records(sent, draft);
  }
  return confirmed;
}

Status StorageManager::thin_frames(Draft& draft) {
  StorageRecord& account = draft.after.account;
  const double quota = release_part().share(wiring_.mission.frame_share);
  ILP_TAKE(
      const Thinning thinning,
      ilp::thin_frames(wiring_.store, static_cast<std::int64_t>(wiring_.mission.high_watermark * quota),
                       static_cast<std::int64_t>(wiring_.mission.low_watermark * quota), draft.after.frames, account));
  draft.changed = draft.changed || thinning != Thinning::idle;
  if (thinning == Thinning::begun)
    draft.event = {StatusCode::frames_thinned, account.frame_bytes, static_cast<std::int64_t>(quota)};
  return {};
}

Status StorageManager::note_mode(Draft& draft) {
  StorageRecord& account = draft.after.account;
  account.budget_bytes = static_cast<std::int64_t>(release_part().share(1));
  const bool was_full = account.full;
  const double watermark = was_full ? wiring_.mission.low_watermark : wiring_.mission.high_watermark;
  const bool full =
      release_part().products_above(draft, watermark) ||
      static_cast<double>(account.depth_bytes) > watermark * release_part().share(wiring_.mission.depth_share);
  if (full == was_full) return {};
  account.full = full;
  if (full) ++account.times_full;
  draft.changed = true;
  const StatusCode code = full ? StatusCode::storage_tight : StatusCode::storage_relieved;
  draft.event = {code, release_part().held_bytes(account), account.budget_bytes};
  return {};
}

Status StorageManager::work_through(Draft& draft) {
  for (int i = 0; i < storage_batch; ++i) {
    ILP_TRY(count_new(draft));
    ILP_TRY(release_part().release(draft));
  }
  ILP_TRY(release_part().release_oldest_points(false, draft).status());
  ILP_TRY(release_part().release_oldest_mask(false, draft).status());
  ILP_TRY(obey_commands(draft));
  ILP_TRY(delete_acknowledged(draft));
  ILP_TRY(products().sweep(draft));
  draft.usage = wiring_.store.usage();
  ILP_TRY(weigh_places());
  ILP_TRY(note_mode(draft));
  if (draft.event.ok()) ILP_TRY(thin_frames(draft));
  if (draft.event.ok()) ILP_TRY(products().abandon_least(draft));
  const std::int64_t erased = draft.after.account.rows_erased;
  ILP_TRY(erase_past(wiring_.store, wiring_.mission, draft.after.frames.passed_id, draft.after.history,
                     draft.after.account.rows_erased));
  draft.changed = draft.changed || draft.after.account.rows_erased != erased;
  return draft.changed ? products().find_oldest(draft) : Status{};
}

bool StorageManager::scanned() {
  work_.rounds_done = work_.rounds_done || work_.round_done;
  work_.searches_done = work_.searches_done || !work_.searching;
  if (!work_.rounds_done || !work_.searches_done) return false;
  work_.rounds_done = work_.searches_done = false;
  return true;
}

StepResult StorageManager::step() {
  Draft draft;
  draft.after = state_;
  StepTransaction transaction(wiring_.whole, checkpoint);
  Status status = transaction.begin();
  if (status.ok()) status = work_through(draft);
  if (!status.ok()) return {status, false};
  if (!draft.changed) return {{}, !scanned()};
  work_.rounds_done = work_.searches_done = false;
  draft.after.account.database_bytes = draft.usage.bytes;
  draft.after.account.database_free_bytes = draft.usage.free_bytes;
  status = put(wiring_.store, draft.after.account);
  if (status.ok()) status = transaction.commit(cursor_, draft.after, cursor_, state_);
  if (!status.ok()) return {status, false};
  return {draft.event, true};
}

}  // namespace ilp
