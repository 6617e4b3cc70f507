#include "fsw/storage/storage_manager.hpp"

#include "fsw/shared/place_room.hpp"
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
Status count_next(Reader<Record> store, std::int64_t& counted_id, std::int64_t& bytes, std::uint32_t& held,
                  bool& changed) {
  Record record;
  bool found = false;
  ILP_TRY(find_next(store, counted_id, record, found));
  if (!found) return {};
  counted_id = record.id;
  bytes += blob_bytes(record);
  if (blob_bytes(record) != 0) ++held;
  changed = true;
  return {};
}

}  // namespace

constexpr CheckpointForm StorageManager::checkpoint = checkpoint_form<State>(component_id);

StorageManager::StorageManager(Tables store, const MissionParameters& mission, Scratch scratch)
    : whole_(store), store_(store), mission_(mission), scratch_(scratch) {}

Status StorageManager::restore() {
  search_.restart();
  searching_ = false;
  gave_up_ = false;
  rounds_done_ = searches_done_ = false;
  asked_id_ = 0;
  swept_id_ = 0;
  weighed_id_ = -1;
  const Status status = restore_checkpoint(whole_, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  // Without a checkpoint the totals on record stay.
  if (!status.ok() || state_.frames.counted_id == 0) ILP_TRY(recount());
  begin_ids<FrameRecord>(store_, state_.frames.passed_id);
  begin_ids<FrameRecord>(store_, state_.frames.counted_id);
  return status;
}

/// An account that is older than the records would stay wrong: held records are counted again, totals stay.
Status StorageManager::recount() {
  StorageRecord known;
  const Status found = get(store_, known.id, known);
  if (!found.ok() && !is_gone(found)) return found;
  if (!found.ok()) known = {};
  known.frame_bytes = known.depth_bytes = known.structure_bytes = known.product_bytes = 0;
  known.frames_held = known.depths_held = known.structures_held = known.products_held = 0;
  state_ = {};
  state_.account = known;
  return {};
}

double StorageManager::share(double part) const {
  return part * mission_.storage_budget_mib * 1048576.0;
}

std::int64_t StorageManager::held_bytes(const StorageRecord& account) const {
  return account.frame_bytes + account.depth_bytes + account.structure_bytes + account.product_bytes + place_bytes_;
}

/// Counting takes time in proportion to the places, whose number changes when a new one comes.
Status StorageManager::weigh_places() {
  std::int64_t newest = 0;
  ILP_TRY(newest_id<PlaceRecord>(store_, newest));
  if (newest == weighed_id_) return {};
  std::int64_t places = 0;
  ILP_TRY(store_.count<PlaceRecord>(places));
  place_bytes_ = places * most_place_bytes;
  weighed_id_ = newest;
  return {};
}

/// A depth map and its mask, once that is final.
Status StorageManager::count_depth(Work& work) {
  State& after = work.after;
  DepthRecord depth;
  bool found = false;
  ILP_TRY(find_next(store_, after.counted_depth_id, depth, found));
  if (!found) return {};
  MaskRecord mask;
  ILP_TRY(find_mask(depth.id, mask));
  if (mask.scope != MaskScope::flight) return {};
  after.counted_depth_id = depth.id;
  const std::int64_t bytes = blob_bytes(depth) + mask.code.bytes;
  after.account.depth_bytes += bytes;
  if (bytes != 0) ++after.account.depths_held;
  work.changed = true;
  return {};
}

Status StorageManager::count_new(Work& work) {
  State& after = work.after;
  StorageRecord& account = after.account;
  bool& changed = work.changed;
  ILP_TRY(count_next<FrameRecord>(store_, after.frames.counted_id, account.frame_bytes, account.frames_held, changed));
  ILP_TRY(count_depth(work));
  ILP_TRY(count_next<StructureRecord>(store_, after.counted_structure_id, account.structure_bytes,
                                      account.structures_held, changed));
  return count_next<ProductRecord>(store_, after.counted_product_id, account.product_bytes, account.products_held,
                                   changed);
}

Status StorageManager::obey_commands(Work& work) {
  // Bounded by the number of commands; one product a step.
  for (bool dropped = false; !dropped;) {
    CommandRecord command;
    const Status found = next(store_, work.after.obeyed_command_id, command);
    if (found.is(StatusCode::not_found)) return {};
    ILP_TRY(found);
    if (command.kind == CommandKind::delete_product) {
      ProductRecord product;
      const Status held = get(store_, command.subject_id, product);
      if (!held.ok() && !is_gone(held)) return held;
      // Products that have not been counted yet are deleted after they are counted.
      if (held.ok() && product.id > work.after.counted_product_id) return {};
      dropped = held.ok() && product.data.bytes != 0;
      if (dropped) ILP_TRY(drop(product, work));
    }
    work.after.obeyed_command_id = command.id;
    work.changed = true;
  }
  return {};
}

Status StorageManager::delete_acknowledged(Work& work) {
  State& after = work.after;
  if (asked_id_ < after.checked_downlink_id) asked_id_ = after.checked_downlink_id;
  bool all_before = asked_id_ == after.checked_downlink_id;
  round_done_ = false;
  DownlinkRecord newest;
  const Status any = last(store_, newest);
  if (!any.ok() && !any.is(StatusCode::not_found)) return any;
  for (int asked = 0; asked < files_per_step; ++asked) {
    DownlinkRecord sent;
    bool found = false;
    ILP_TRY(find_next(store_, asked_id_, sent, found));
    if (!found) {
      // In turns over all files, so that a missing confirmation does not delay those after it.
      asked_id_ = 0;
      round_done_ = true;
      return {};
    }
    asked_id_ = sent.id;
    bool settled = false;
    ILP_TRY(settle(sent, newest.sent_ns, work, settled));
    all_before = all_before && settled;
    if (all_before) {
      after.checked_downlink_id = sent.id;
      work.changed = true;
    }
  }
  return {};
}

Status StorageManager::settle(const DownlinkRecord& sent, TimeNs newest_sent_ns, Work& work, bool& settled) {
  settled = sent.acknowledged_ns != 0;
  if (sent.kind == DownlinkKind::product) return settle_product(sent, newest_sent_ns, work);
  if (!settled) return {};
  if (sent.kind == DownlinkKind::points) return settle_points(sent, work, settled);
  return sent.subject_id > 0 ? settle_records(sent, work, settled) : Status{};
}

Status StorageManager::thin_frames(Work& work) {
  StorageRecord& account = work.after.account;
  const double quota = share(mission_.frame_share);
  bool began = false;
  ILP_TRY(ilp::thin_frames(store_, static_cast<std::int64_t>(mission_.high_watermark * quota),
                           static_cast<std::int64_t>(mission_.low_watermark * quota), work.after.frames, account,
                           work.changed, began));
  if (began) work.event = {StatusCode::frames_thinned, account.frame_bytes, static_cast<std::int64_t>(quota)};
  return {};
}

bool StorageManager::products_above(const Work& work, double watermark) const {
  const StorageRecord& account = work.after.account;
  const std::int64_t used = work.usage.bytes - work.usage.free_bytes;
  const std::int64_t room = work.usage.limit_bytes > 0 ? work.usage.limit_bytes : database_limit_bytes(mission_);
  return static_cast<double>(held_bytes(account)) > watermark * share(1) ||
         static_cast<double>(account.product_bytes) > watermark * share(mission_.product_share) ||
         static_cast<double>(used) > watermark * static_cast<double>(room);
}

Status StorageManager::note_mode(Work& work) {
  StorageRecord& account = work.after.account;
  account.budget_bytes = static_cast<std::int64_t>(share(1));
  const bool was_full = account.full;
  const double watermark = was_full ? mission_.low_watermark : mission_.high_watermark;
  const bool full = products_above(work, watermark) ||
                    static_cast<double>(account.depth_bytes) > watermark * share(mission_.depth_share);
  if (full == was_full) return {};
  account.full = full;
  if (full) ++account.times_full;
  work.changed = true;
  const StatusCode code = full ? StatusCode::storage_tight : StatusCode::storage_relieved;
  work.event = {code, held_bytes(account), account.budget_bytes};
  return {};
}

Status StorageManager::work_through(Work& work) {
  for (int i = 0; i < batch; ++i) {
    ILP_TRY(count_new(work));
    ILP_TRY(release(work));
  }
  bool released = false;
  ILP_TRY(release_oldest_points(false, work, released));
  ILP_TRY(release_oldest_mask(false, work, released));
  ILP_TRY(obey_commands(work));
  ILP_TRY(delete_acknowledged(work));
  ILP_TRY(sweep(work));
  work.usage = store_.usage();
  ILP_TRY(weigh_places());
  ILP_TRY(note_mode(work));
  if (work.event.ok()) ILP_TRY(thin_frames(work));
  if (work.event.ok()) ILP_TRY(give_up_least(work));
  const std::int64_t erased = work.after.account.rows_erased;
  ILP_TRY(
      erase_past(store_, mission_, work.after.frames.passed_id, work.after.history, work.after.account.rows_erased));
  work.changed = work.changed || work.after.account.rows_erased != erased;
  return work.changed ? find_oldest(work) : Status{};
}

bool StorageManager::looked_through() {
  rounds_done_ = rounds_done_ || round_done_;
  searches_done_ = searches_done_ || !searching_;
  if (!rounds_done_ || !searches_done_) return false;
  rounds_done_ = searches_done_ = false;
  return true;
}

StepResult StorageManager::step() {
  Work work;
  work.after = state_;
  StepTransaction transaction(whole_, checkpoint);
  Status status = transaction.begin();
  if (status.ok()) status = work_through(work);
  if (!status.ok()) return {status, false};
  if (!work.changed) return {{}, !looked_through()};
  rounds_done_ = searches_done_ = false;
  work.after.account.database_bytes = work.usage.bytes;
  work.after.account.database_free_bytes = work.usage.free_bytes;
  status = put(store_, work.after.account);
  if (status.ok()) status = transaction.commit(cursor_, work.after, cursor_, state_);
  if (!status.ok()) return {status, false};
  return {work.event, true};
}

}  // namespace ilp
