#include "fsw/storage/storage_manager.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/shared/product_layers.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int batch = 8;
constexpr int files_per_step = 64;
constexpr int products_per_sweep = 8;
// The check of a strip against the camera looks at points of its first or last keyframes, and their windows.
constexpr std::int64_t keyframes_with_points = 100;

std::int64_t held_bytes(const StorageRecord& account) {
  return account.frame_bytes + account.depth_bytes + account.structure_bytes + account.product_bytes;
}

std::int64_t blob_bytes(const FrameRecord& frame) {
  return frame.image.bytes;
}
std::int64_t blob_bytes(const DepthRecord& depth) {
  return std::int64_t{depth.values.bytes} + depth.sigma.bytes + depth.mask.bytes;
}
std::int64_t blob_bytes(const StructureRecord& structure) {
  return structure.points.bytes;
}
std::int64_t blob_bytes(const ProductRecord& product) {
  return product.data.bytes;
}

/// The record after `after_id`; false if there is none.
template <typename Record>
Status find_next(Reader<Record> store, std::int64_t after_id, Record& record, bool& found) {
  const Status status = next(store, after_id, record);
  found = status.ok();
  return status.is(StatusCode::not_found) ? Status{} : status;
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

StorageManager::StorageManager(Tables store, const MissionParameters& mission)
    : whole_(store), store_(store), mission_(mission) {}

Status StorageManager::restore() {
  search_.restart();
  searching_ = false;
  gave_up_ = false;
  rounds_done_ = searches_done_ = false;
  asked_id_ = 0;
  swept_id_ = 0;
  const Status status = restore_checkpoint(whole_, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  if (!status.ok()) ILP_TRY(count_anew());
  begin_ids<FrameRecord>(store_, state_.frames.passed_id);
  begin_ids<FrameRecord>(store_, state_.frames.counted_id);
  return status;
}

/// An account that is older than the records would stay wrong: held records are counted again, totals stay.
Status StorageManager::count_anew() {
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

Status StorageManager::count_new(Work& work) {
  State& after = work.after;
  StorageRecord& account = after.account;
  bool& changed = work.changed;
  ILP_TRY(count_next<FrameRecord>(store_, after.frames.counted_id, account.frame_bytes, account.frames_held, changed));
  ILP_TRY(count_next<DepthRecord>(store_, after.counted_depth_id, account.depth_bytes, account.depths_held, changed));
  ILP_TRY(count_next<StructureRecord>(store_, after.counted_structure_id, account.structure_bytes,
                                      account.structures_held, changed));
  return count_next<ProductRecord>(store_, after.counted_product_id, account.product_bytes, account.products_held,
                                   changed);
}

Status StorageManager::release_depth(Work& work) {
  State& after = work.after;
  bool found = false;
  DepthRecord depth;
  ILP_TRY(find_next(store_, after.coded_depth_id, depth, found));
  // The image of a keyframe is coded after its depth map.
  if (found && depth.id <= after.counted_depth_id &&
      after.counted_product_id >= product_id(depth.id, ProductKind::image)) {
    after.coded_depth_id = depth.id;
    after.account.depth_bytes -= std::int64_t{depth.values.bytes} + depth.sigma.bytes;
    if (blob_bytes(depth) != 0 && depth.mask.bytes == 0) --after.account.depths_held;
    depth.values.bytes = 0;
    depth.sigma.bytes = 0;
    work.changed = true;
    ILP_TRY(amend(store_, depth));
  }
  return {};
}

Status StorageManager::release_mask(DepthRecord depth, Work& work) {
  work.after.account.depth_bytes -= depth.mask.bytes;
  --work.after.account.depths_held;
  depth.mask.bytes = 0;
  work.changed = true;
  return amend(store_, depth);
}

Status StorageManager::release_points(StructureRecord structure, bool held, Work& work) {
  StorageRecord& account = work.after.account;
  account.structure_bytes -= structure.points.bytes;
  --account.structures_held;
  if (!held) ++account.structures_dropped;
  if (!held) account.dropped_bytes += structure.points.bytes;
  structure.points.bytes = 0;
  work.changed = true;
  return amend(store_, structure);
}

Status StorageManager::age_points(Work& work) {
  State& after = work.after;
  bool found = false;
  StructureRecord structure;
  ILP_TRY(find_next(store_, after.aged_structure_id, structure, found));
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
    // Ids of a later life of the flight begin far after this: no bit is left to be moved.
    if (!any) after.aged_structure_id = structure.id - 1;
  }
  work.changed = true;
  return held && structure.points.bytes != 0 ? release_points(structure, true, work) : Status{};
}

Status StorageManager::unneeded_before(std::int64_t& keyframe_id) {
  // For as long as records without a confirmation stay: record_history.hpp.
  KeyframeRecord newest;
  const Status any = last(store_, newest);
  keyframe_id = any.ok() ? newest.id - unconfirmed_factor * mission_.history_keyframes : 0;
  return is_gone(any) ? Status{} : any;
}

Status StorageManager::release_oldest_points(bool full, Work& work, bool& released) {
  released = false;
  State& after = work.after;
  std::int64_t unneeded = 0;
  ILP_TRY(unneeded_before(unneeded));
  for (int i = 0; i < batch && !released; ++i) {
    bool found = false;
    StructureRecord structure;
    ILP_TRY(find_next(store_, after.released_structure_id, structure, found));
    if (!found || structure.id > after.aged_structure_id) return {};
    released = structure.points.bytes != 0;
    if (released && !full && structure.id > unneeded) {
      released = false;
      return {};
    }
    after.released_structure_id = structure.id;
    work.changed = true;
    if (released) ILP_TRY(release_points(structure, false, work));
  }
  return {};
}

Status StorageManager::release_oldest_mask(bool full, Work& work, bool& released) {
  released = false;
  State& after = work.after;
  std::int64_t unneeded = 0;
  ILP_TRY(unneeded_before(unneeded));
  // The newest file shows how far records were sent.
  DownlinkRecord sent;
  const Status any = full ? last(store_, sent) : Status{StatusCode::not_found};
  if (!any.ok() && !any.is(StatusCode::not_found)) return any;
  if (sent.records_through > unneeded) unneeded = sent.records_through;
  for (int i = 0; i < batch && !released; ++i) {
    bool found = false;
    DepthRecord depth;
    ILP_TRY(find_next(store_, after.released_depth_id, depth, found));
    if (!found || depth.id > after.coded_depth_id) return {};
    if (depth.mask.bytes != 0 && depth.id > unneeded) return {};
    released = depth.mask.bytes != 0;
    after.released_depth_id = depth.id;
    work.changed = true;
    if (!released) continue;
    after.account.dropped_bytes += depth.mask.bytes;
    ILP_TRY(release_mask(depth, work));
  }
  return {};
}

Status StorageManager::release(Work& work) {
  State& after = work.after;
  ILP_TRY(release_frame(store_, after.frames, after.account, work.changed));
  ILP_TRY(release_keyframe_image(store_, after.counted_product_id, after.frames, after.account, work.changed));
  ILP_TRY(release_depth(work));
  return age_points(work);
}

Status StorageManager::delete_product(const ProductRecord& product, Work& work) {
  // Products that have not been counted are not in the account.
  if (product.id > work.after.counted_product_id) return {};
  StorageRecord& account = work.after.account;
  account.product_bytes -= product.data.bytes;
  account.acknowledged_bytes += product.data.bytes;
  if (product.data.bytes != 0) --account.products_held;
  ++account.products_acknowledged;
  work.changed = true;
  return erase<ProductRecord>(store_, product.id);
}

Status StorageManager::give_up(ProductRecord product, Work& work) {
  StorageRecord& account = work.after.account;
  account.product_bytes -= product.data.bytes;
  account.dropped_bytes += product.data.bytes;
  --account.products_held;
  product.state = ProductState::dropped;
  product.data.bytes = 0;
  work.changed = true;
  return amend(store_, product);
}

Status StorageManager::give_up_damaged(const ProductRecord& product, Work& work) {
  if (product.id > work.after.counted_product_id || product.data.bytes == 0) return {};
  ++work.after.account.products_damaged;
  return give_up(product, work);
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

Status StorageManager::settle_records(const DownlinkRecord& sent, Work& work, bool& settled) {
  DepthRecord depth;
  const Status found = get(store_, sent.subject_id, depth);
  if (is_gone(found)) return {};
  ILP_TRY(found);
  settled = depth.id <= work.after.coded_depth_id;
  return settled && depth.mask.bytes != 0 ? release_mask(depth, work) : Status{};
}

Status StorageManager::settle_points(const DownlinkRecord& sent, Work& work, bool& settled) {
  State& after = work.after;
  const std::int64_t place = sent.subject_id - after.aged_structure_id - 1;
  if (place >= 0) {
    settled = place < points_window;
    if (!settled) return {};
    std::uint64_t& bits = after.points_held[static_cast<std::size_t>(place / 64)];
    const std::uint64_t bit = std::uint64_t{1} << static_cast<unsigned>(place % 64);
    work.changed = work.changed || (bits & bit) == 0;
    bits |= bit;
    return {};
  }
  StructureRecord structure;
  const Status found = get(store_, sent.subject_id, structure);
  if (is_gone(found)) return {};
  ILP_TRY(found);
  return structure.points.bytes != 0 ? release_points(structure, true, work) : Status{};
}

Status StorageManager::settle_product(const DownlinkRecord& sent, TimeNs newest_sent_ns, Work& work) {
  ProductRecord product;
  const Status held = get(store_, sent.subject_id, product);
  if (is_gone(held)) return {};
  ILP_TRY(held);
  if (sent.acknowledged_ns != 0) {
    // The file may have held only some of its layers.
    return product.state == ProductState::acknowledged ? delete_product(product, work) : Status{};
  }
  const double waited_s = 1e-9 * static_cast<double>(newest_sent_ns - sent.sent_ns);
  const bool lost = mission_.confirmation_timeout_s > 0 && waited_s > mission_.confirmation_timeout_s;
  return lost ? send_again(sent, product, work) : Status{};
}

Status StorageManager::send_again(const DownlinkRecord& lost, ProductRecord product, Work& work) {
  ILP_TRY(erase<DownlinkRecord>(store_, lost.id));
  ++work.after.account.files_lost;
  work.changed = true;
  const bool open = product.state == ProductState::stored || product.state == ProductState::sent;
  if (!open || product.data.bytes == 0) return {};
  // Layers on the ground stay sent; those of this file and after it are sent again.
  const int layers_before = lost.first_layer > 0 ? lost.first_layer - 1 : 0;
  if (product.layers_sent > layers_before) product.layers_sent = static_cast<std::uint8_t>(layers_before);
  product.state = ProductState::stored;
  return amend(store_, product);
}

Status StorageManager::sweep(Work& work) {
  for (int i = 0; i < products_per_sweep; ++i) {
    ProductRecord product;
    bool found = false;
    ILP_TRY(find_next(store_, swept_id_, product, found));
    swept_id_ = found ? product.id : 0;
    if (!found) return {};
    if (product.state == ProductState::acknowledged) ILP_TRY(delete_product(product, work));
    // It was abandoned elsewhere, so its bytes are of no use.
    if (product.state == ProductState::dropped) ILP_TRY(give_up_damaged(product, work));
  }
  return {};
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
  const bool was_full = account.full != 0;
  const double watermark = was_full ? mission_.low_watermark : mission_.high_watermark;
  const bool full = products_above(work, watermark) ||
                    static_cast<double>(account.depth_bytes) > watermark * share(mission_.depth_share);
  if (full == was_full) return {};
  account.full = full ? 1 : 0;
  if (full) ++account.times_full;
  work.changed = true;
  const StatusCode code = full ? StatusCode::storage_tight : StatusCode::storage_relieved;
  work.event = {code, held_bytes(account), account.budget_bytes};
  return {};
}

Status StorageManager::drop(const ProductRecord& product, Work& work) {
  ++work.after.account.products_dropped;
  work.event = {StatusCode::product_dropped, product.id, static_cast<std::int64_t>(product.priority * 1000)};
  return give_up(product, work);
}

Status StorageManager::cut_last_layer(ProductRecord product, Work& work, bool& done) {
  done = false;
  const std::size_t before = product.data.bytes;
  ILP_ASSERT(before <= file_.size(), before);
  // Bytes that cannot be read stay: the disk may recover, and the downlink judges them itself.
  if (!read_blob<ProductRecord>(store_, "data", product.id, 0, {file_.data(), before}).ok()) return {};
  done = true;
  std::size_t bytes = 0;
  const bool sound = crc32({file_.data(), before}) == product.crc32 &&
                     truncate_to_layers({file_.data(), before}, product.layers - 1, bytes).ok() && bytes < before;
  if (!sound) {
    work.event = {StatusCode::product_damaged, product.id};
    return give_up_damaged(product, work);
  }
  StorageRecord& account = work.after.account;
  const auto freed = static_cast<std::int64_t>(before - bytes);
  account.product_bytes -= freed;
  account.cut_bytes += freed;
  ++account.layers_cut;
  keep_layers(product.layers - 1, bytes, product);
  product.data.bytes = product.bytes;
  product.crc32 = crc32({file_.data(), bytes});
  if (product.layers == product.layers_sent) {
    // All remaining layers were sent.
    product.state = all_held(product) ? ProductState::acknowledged : ProductState::sent;
  }
  work.changed = true;
  ILP_TRY(amend(store_, product));
  return write_blob<ProductRecord>(store_, "data", product.id, 0, {file_.data(), bytes});
}

Status StorageManager::give_up_least(Work& work) {
  const StorageRecord& account = work.after.account;
  // Erasing products makes no room for depth maps.
  const bool wanted = account.full != 0 && products_above(work, mission_.low_watermark);
  searching_ = false;
  if (!wanted) {
    search_.restart();
    return {};
  }
  // The last in the downlink's order are first here; then those that the ground probably holds.
  bool released = false;
  ILP_TRY(release_oldest_points(true, work, released));
  if (released) return {};
  ILP_TRY(release_oldest_mask(true, work, released));
  if (released) return {};
  if (!search_.complete()) {
    ILP_TRY(search_.look(store_, work.after.counted_product_id));
    searching_ = !search_.complete();
    if (searching_) return {};
  }
  VictimSearch::Victim victim;
  bool whole = false;
  while (search_.take(victim, whole)) {
    ProductRecord product;
    const Status found = get(store_, victim.product_id, product);
    if (is_gone(found)) continue;
    ILP_TRY(found);
    // It may have been sent since.
    bool done = false;
    if (whole && product_can_go(product)) {
      done = true;
      ILP_TRY(drop(product, work));
    } else if (!whole && last_layer_can_go(product)) {
      ILP_TRY(cut_last_layer(product, work, done));
    }
    gave_up_ = gave_up_ || done;
    if (done) return {};
  }
  search_.restart();
  // A product that has lost its last layer has another last one.
  searching_ = gave_up_;
  gave_up_ = false;
  return {};
}

Status StorageManager::find_oldest(Work& work) {
  State& after = work.after;
  ProductRecord product;
  bool found = false;
  for (int i = 0; i < batch; ++i) {
    ILP_TRY(find_next(store_, after.oldest_product_id, product, found));
    if (!found || product.data.bytes != 0 || product.id > after.counted_product_id) break;
    after.oldest_product_id = product.id;
  }
  after.account.oldest_age_ns = 0;
  if (!found || product.data.bytes == 0) return {};
  KeyframeRecord newest, oldest;
  Status known = last(store_, newest);
  if (known.ok()) known = get(store_, product.keyframe_id, oldest);
  if (is_gone(known)) return {};
  ILP_TRY(known);
  if (newest.time_ns > oldest.time_ns) after.account.oldest_age_ns = newest.time_ns - oldest.time_ns;
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
