#include "fsw/components/storage_manager.hpp"

namespace ilp {
namespace {
constexpr std::uint32_t layout = 1;

std::int64_t held_bytes(const StorageRecord& account) {
  return account.frame_bytes + account.depth_bytes + account.product_bytes;
}
std::int64_t depth_bytes(const DepthRecord& depth) {
  return std::int64_t{depth.values.bytes} + depth.sigma.bytes + depth.mask.bytes;
}
}  // namespace

StorageManager::StorageManager(Store& store, const MissionParameters& mission) : store_(store), mission_(mission) {}

Status StorageManager::restore() {
  return restore_checkpoint(store_, ComponentId::storage_manager, cursor_, layout, state_);
}

Status StorageManager::count_new(State& after, bool& changed) {
  FrameRecord frame;
  if (const Status found = next(store_, after.counted_frame_id, frame); found.ok()) {
    after.counted_frame_id = frame.id;
    after.account.frame_bytes += frame.image.bytes;
    changed = true;
  } else if (!found.is(StatusCode::not_found)) {
    return found;
  }
  DepthRecord depth;
  if (const Status found = next(store_, after.counted_depth_id, depth); found.ok()) {
    after.counted_depth_id = depth.id;
    after.account.depth_bytes += depth_bytes(depth);
    changed = true;
  } else if (!found.is(StatusCode::not_found)) {
    return found;
  }
  ProductRecord product;
  if (const Status found = next(store_, after.counted_product_id, product); found.ok()) {
    after.counted_product_id = product.id;
    after.account.product_bytes += product.data.bytes;
    changed = true;
  } else if (!found.is(StatusCode::not_found)) {
    return found;
  }
  return {};
}

Status StorageManager::release_frame(State& after, bool& changed) {
  const std::int64_t frame_id = after.released_frame_id + 1;
  if (frame_id > after.counted_frame_id) return {};
  KeyframeRecord newest;
  const Status any = last(store_, newest);
  if (any.is(StatusCode::not_found)) return {};
  ILP_TRY(any);
  // Behind the newest keyframe the overlap checker may still choose.
  if (frame_id >= newest.frame_id) return {};

  KeyframeRecord keyframe;
  ILP_TRY(next(store_, after.keyframe_id, keyframe));
  if (keyframe.frame_id == frame_id) {
    const bool products_made = after.counted_product_id >= product_id(keyframe.id, ProductKind::image);
    if (!products_made) return {};
    after.keyframe_id = keyframe.id;
  }
  FrameRecord frame;
  ILP_TRY(get(store_, frame_id, frame));
  after.account.frame_bytes -= frame.image.bytes;
  ++after.account.frames_released;
  after.released_frame_id = frame_id;
  frame.image.bytes = 0;
  changed = true;
  return put(store_, frame);
}

Status StorageManager::release_depth(State& after, bool& changed) {
  DepthRecord depth;
  const Status found = next(store_, after.released_depth_id, depth);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  if (depth.id > after.counted_depth_id) return {};
  // The records file of a keyframe carries its mask, and is sent before the products: see downlink.hpp.
  DownlinkRecord sent;
  const Status any = last(store_, sent);
  if (any.is(StatusCode::not_found)) return {};
  ILP_TRY(any);
  if (sent.records_through < depth.id) return {};
  after.account.depth_bytes -= depth_bytes(depth);
  after.released_depth_id = depth.id;
  depth.values.bytes = 0;
  depth.sigma.bytes = 0;
  depth.mask.bytes = 0;
  changed = true;
  return put(store_, depth);
}

Status StorageManager::delete_acknowledged(State& after, bool& changed) {
  DownlinkRecord sent;
  const Status found = next(store_, after.checked_downlink_id, sent);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  if (sent.acknowledged_ns == 0) return {};
  after.checked_downlink_id = sent.id;
  changed = true;
  if (sent.kind != DownlinkKind::product) return {};
  ProductRecord product;
  const Status held = get(store_, sent.subject_id, product);
  if (held.is(StatusCode::not_found)) return {};
  ILP_TRY(held);
  // The file may have brought some of its layers only.
  if (product.state != ProductState::acknowledged) return {};
  after.account.product_bytes -= product.data.bytes;
  ++after.account.products_acknowledged;
  return store_.erase(record_info<ProductRecord>(), product.id);
}

Status StorageManager::drop_least(State& after, bool& changed, Status& event) {
  after.account.budget_bytes = static_cast<std::int64_t>(mission_.storage_budget_mib * 1048576.0);
  if (held_bytes(after.account) <= after.account.budget_bytes) return {};
  ProductRecord least;
  bool any = false;
  ProductRecord product;
  std::int64_t after_id = 0;
  // Bounded by what the budget can hold.
  for (Status found = next(store_, after_id, product); found.ok(); found = next(store_, after_id, product)) {
    after_id = product.id;
    if (product.data.bytes == 0) continue;
    // Given up elsewhere: its bytes are of no use to anybody.
    if (product.state == ProductState::dropped) product.priority = -1;
    if (product.state != ProductState::stored && product.state != ProductState::dropped) continue;
    if (!any || product.priority < least.priority) least = product;
    any = true;
  }
  if (!any) return {};
  after.account.product_bytes -= least.data.bytes;
  ++after.account.products_dropped;
  event = {StatusCode::product_dropped, least.id, static_cast<std::int64_t>(least.priority * 1000)};
  least.state = ProductState::dropped;
  least.data.bytes = 0;
  changed = true;
  return put(store_, least);
}

Status StorageManager::save(const State& after) {
  ILP_TRY(put(store_, after.account));
  return save_checkpoint(store_, ComponentId::storage_manager, cursor_, layout, after);
}

StepResult StorageManager::step(TimeNs deadline) {
  static_cast<void>(deadline);
  State after = state_;
  bool changed = false;
  Status event;
  Transaction transaction(store_);
  Status status = transaction.begin();
  if (status.ok()) status = count_new(after, changed);
  if (status.ok()) status = release_frame(after, changed);
  if (status.ok()) status = release_depth(after, changed);
  if (status.ok()) status = delete_acknowledged(after, changed);
  if (status.ok()) status = drop_least(after, changed, event);
  if (!status.ok()) return {status, false};
  if (!changed) return {};
  after.account.database_bytes = store_.usage().bytes;
  status = save(after);
  if (status.ok()) status = transaction.commit();
  if (!status.ok()) return {status, false};
  state_ = after;
  return {event, true};
}

}  // namespace ilp
