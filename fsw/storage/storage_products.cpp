#include "fsw/storage/storage_products.hpp"

#include "fsw/storage/storage_release.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/product_layers.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {
namespace {

constexpr int products_per_sweep = 8;

}  // namespace

Status StorageProducts::delete_product(const ProductRecord& product, Draft& draft) {
  // Products that have not been counted are not in the account.
  if (product.id > draft.after.counted_product_id) return {};
  StorageRecord& account = draft.after.account;
  account.product_bytes -= product.data.bytes;
  account.acknowledged_bytes += product.data.bytes;
  if (product.data.bytes != 0) --account.products_held;
  ++account.products_acknowledged;
  draft.changed = true;
  return erase<ProductRecord>(wiring_.store, product.id);
}

Status StorageProducts::abandon(ProductRecord product, Draft& draft) {
  StorageRecord& account = draft.after.account;
  account.product_bytes -= product.data.bytes;
  account.dropped_bytes += product.data.bytes;
  --account.products_held;
  product.state = ProductState::dropped;
  product.data.bytes = 0;
  draft.changed = true;
  return amend(wiring_.store, product);
}

Status StorageProducts::abandon_damaged(const ProductRecord& product, Draft& draft) {
  if (product.id > draft.after.counted_product_id || product.data.bytes == 0) return {};
  ++draft.after.account.products_damaged;
  return abandon(product, draft);
}

Status StorageProducts::drop(const ProductRecord& product, Draft& draft) {
  ++draft.after.account.products_dropped;
  draft.event = {StatusCode::product_dropped, product.id, static_cast<std::int64_t>(product.priority * 1000)};
  return abandon(product, draft);
}

Result<bool> StorageProducts::cut_last_layer(ProductRecord product, Draft& draft) {
  const std::size_t before = product.data.bytes;
  auto& file = wiring_.scratch.as<StorageFile>();
  ILP_ASSERT(before <= file.size(), before);
  // Bytes that cannot be read stay: the disk may recover, and the downlink judges them itself.
  if (!read_blob<ProductRecord>(wiring_.store, "data", product.id, 0, {file.data(), before}).ok()) return false;
  std::size_t bytes = 0;
  const bool valid = crc32({file.data(), before}) == product.crc32 &&
                     truncate_to_layers({file.data(), before}, product.layers - 1, bytes).ok() && bytes < before;
  if (!valid) {
    draft.event = {StatusCode::product_damaged, product.id};
    ILP_TRY(abandon_damaged(product, draft));
    return true;
  }
  StorageRecord& account = draft.after.account;
  const auto freed = static_cast<std::int64_t>(before - bytes);
  account.product_bytes -= freed;
  account.cut_bytes += freed;
  ++account.layers_cut;
  keep_layers(product.layers - 1, bytes, product);
  product.data.bytes = product.bytes;
  product.crc32 = crc32({file.data(), bytes});
  if (product.layers == product.layers_sent) {
    // All remaining layers were sent.
    product.state = all_held(product) ? ProductState::acknowledged : ProductState::sent;
  }
  draft.changed = true;
  ILP_TRY(amend(wiring_.store, product));
  ILP_TRY(write_blob<ProductRecord>(wiring_.store, "data", product.id, 0, {file.data(), bytes}));
  return true;
}

Status StorageProducts::abandon_least(Draft& draft) {
  const StorageRecord& account = draft.after.account;
  // Erasing products makes no room for depth maps.
  const bool wanted = account.full && products_above(draft, wiring_.mission.low_watermark);
  work_.searching = false;
  if (!wanted) {
    work_.search.restart();
    return {};
  }
  // The last in the downlink's order are first here; then those that the ground probably holds.
  ILP_TAKE(const bool points_went, StorageRelease(wiring_, work_).release_oldest_points(true, draft));
  if (points_went) return {};
  ILP_TAKE(const bool mask_went, StorageRelease(wiring_, work_).release_oldest_mask(true, draft));
  if (mask_went) return {};
  if (!work_.search.complete()) {
    ILP_TRY(work_.search.look(wiring_.store, draft.after.counted_product_id));
    work_.searching = !work_.search.complete();
    if (work_.searching) return {};
  }
  const bool whole = work_.search.of_whole_products();
  VictimSearch::Victim victim;
  while (work_.search.take(victim)) {  // bound: the victims of one search
    ProductRecord product;
    ILP_TAKE(const bool found, find(wiring_.store, victim.product_id, product));
    // It may have been sent since.
    if (!found || !(whole ? product_can_go(product) : last_layer_can_go(product))) continue;
    bool done = whole;
    if (whole) {
      ILP_TRY(drop(product, draft));
    } else {
      ILP_TAKE(done, cut_last_layer(product, draft));
    }
    if (!done) continue;
    work_.has_abandoned = true;
    return {};
  }
  work_.search.restart();
  // A product that has lost its last layer has another last one.
  work_.searching = work_.has_abandoned;
  work_.has_abandoned = false;
  return {};
}

Status StorageProducts::find_oldest(Draft& draft) {
  State& after = draft.after;
  ProductRecord product;
  bool found = false;
  for (int i = 0; i < batch; ++i) {
    ILP_TAKE(found, find_next_valid(wiring_.store, after.oldest_product_id, product));
    if (!found || product.data.bytes != 0 || product.id > after.counted_product_id) break;
    after.oldest_product_id = product.id;
  }
  after.account.oldest_age_ns = 0;
  if (!found || product.data.bytes == 0) return {};
  KeyframeRecord newest, oldest;
  ILP_TAKE(const bool any, found_by(last(wiring_.store, newest)));
  if (!any) return {};
  ILP_TAKE(const bool known, find(wiring_.store, product.keyframe_id, oldest));
  if (known && newest.time_ns > oldest.time_ns) after.account.oldest_age_ns = newest.time_ns - oldest.time_ns;
  return {};
}

Status StorageProducts::finish_product(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft) {
  ProductRecord product;
  ILP_TAKE(const bool held, find(wiring_.store, sent.subject_id, product));
  if (!held) return {};
  if (sent.acknowledged_ns != 0) {
    // The file may have held only some of its layers.
    return product.state == ProductState::acknowledged ? delete_product(product, draft) : Status{};
  }
  const double waited_s = 1e-9 * static_cast<double>(newest_sent_ns - sent.sent_ns);
  const bool lost = wiring_.mission.confirmation_timeout_s > 0 && waited_s > wiring_.mission.confirmation_timeout_s;
  return lost ? send_again(sent, product, draft) : Status{};
}

Status StorageProducts::send_again(const DownlinkRecord& lost, ProductRecord product, Draft& draft) {
  ILP_TRY(erase<DownlinkRecord>(wiring_.store, lost.id));
  ++draft.after.account.files_lost;
  draft.changed = true;
  const bool open = product.state == ProductState::stored || product.state == ProductState::sent;
  if (!open || product.data.bytes == 0) return {};
  // Layers on the ground stay sent; those of this file and after it are sent again.
  const int layers_before = lost.first_layer > 0 ? lost.first_layer - 1 : 0;
  if (product.layers_sent > layers_before) product.layers_sent = static_cast<std::uint8_t>(layers_before);
  product.state = ProductState::stored;
  return amend(wiring_.store, product);
}

Status StorageProducts::sweep(Draft& draft) {
  for (int i = 0; i < products_per_sweep; ++i) {
    ProductRecord product;
    ILP_TAKE(const bool found, find_next_valid(wiring_.store, work_.swept_id, product));
    work_.swept_id = found ? product.id : 0;
    if (!found) return {};
    if (product.state == ProductState::acknowledged) ILP_TRY(delete_product(product, draft));
    // It was abandoned elsewhere, so its bytes are of no use.
    if (product.state == ProductState::dropped) ILP_TRY(abandon_damaged(product, draft));
  }
  return {};
}

}  // namespace ilp
