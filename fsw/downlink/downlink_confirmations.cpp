#include "fsw/downlink/downlink_confirmations.hpp"

#include "fsw/shared/product_layers.hpp"

namespace ilp {
namespace {

constexpr int acknowledgements_per_step = 16;

}  // namespace

Status DownlinkConfirmations::confirm_layers(const DownlinkRecord& record, ProductRecord product) {
  for (unsigned layer = record.first_layer; layer >= 1 && layer <= record.last_layer; ++layer) {
    product.layers_held = static_cast<std::uint8_t>(product.layers_held | (1U << (layer - 1)));
  }
  if (product.layers_sent >= layers_of(product) && all_held(product)) product.state = ProductState::acknowledged;
  return amend(wiring_.store, product);
}

Result<bool> DownlinkConfirmations::drop_if_lost(const DownlinkRecord& record, State& after) {
  if (record.kind == DownlinkKind::product || wiring_.mission.confirmation_timeout_s <= 0) return false;
  const double waited_s = 1e-9 * static_cast<double>(work_.newest_sent_ns - record.sent_ns);
  if (waited_s <= wiring_.mission.confirmation_timeout_s) return false;
  LateFile late{FileClass::records, record.subject_id};
  if (record.kind == DownlinkKind::points) late.kind = FileClass::points;
  if (record.subject_id < 0) late = {FileClass::events, -record.subject_id};
  bool again = record.subject_id == 0;
  for (const LateFile& one : after.late) again = again || one == late;
  if (!again && !after.late.push_back(late)) return false;
  ILP_TRY(erase<DownlinkRecord>(wiring_.store, record.id));
  work_.event = {StatusCode::file_lost, late.id, static_cast<std::int64_t>(late.kind)};
  return true;
}

Result<bool> DownlinkConfirmations::read_confirmation(DownlinkRecord record, State& after) {
  ProductRecord product;
  bool known = false;
  if (record.kind == DownlinkKind::product) {
    const Result<bool> found = find(wiring_.store, record.subject_id, product);
    // The link may report it only once: it is queried when the product can be updated.
    if (!found.ok()) return false;
    known = found.value();
  }
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;
  const Status answer = wiring_.link.acknowledged(record.name, bytes, crc);
  // A damaged copy on the ground is no confirmation; the file stays on board.
  if (!answer.ok() || bytes != record.bytes || crc != record.crc32) return drop_if_lost(record, after);
  record.acknowledged_ns = wiring_.clock.now();
  ILP_TRY(put(wiring_.store, record));
  if (known) ILP_TRY(confirm_layers(record, product));
  return true;
}

Result<bool> DownlinkConfirmations::confirm(State& after) {
  bool any_confirmed = false;
  DownlinkRecord record;
  // A missing confirmation must not delay later ones, so all unconfirmed files take turns.
  if (work_.asked_through < after.acknowledged_through) work_.asked_through = after.acknowledged_through;
  std::int64_t id = work_.asked_through;
  bool all_before = id == after.acknowledged_through;
  bool ended = false;
  for (int asked = 0; asked < acknowledgements_per_step && !(any_confirmed && work_.confirm_alone > 0); ++asked) {
    ILP_TAKE(const Found found, find_next(wiring_.store, id, record));
    ended = found == Found::nothing;
    if (ended) break;
    id = record.id;
    bool confirmed = true;
    if (found == Found::damaged) {
      any_confirmed = true;
      after.check_products_from = 1;
      ILP_TRY(erase<DownlinkRecord>(wiring_.store, id));
    } else {
      confirmed = record.acknowledged_ns != 0;
      // If this one fails, the earlier ones are committed without it.
      work_.asked_through = id;
      if (!confirmed) {
        ILP_TAKE(confirmed, read_confirmation(record, after));
        any_confirmed = any_confirmed || confirmed;
      }
    }
    all_before = all_before && confirmed;
    if (all_before) after.acknowledged_through = id;
  }
  if (any_confirmed && work_.confirm_alone > 0) --work_.confirm_alone;
  work_.asked_through = ended ? after.acknowledged_through : id;
  return any_confirmed;
}

Result<bool> DownlinkConfirmations::check_products(State& after) {
  constexpr int products_per_step = 8;
  const bool changed = after.check_products_from > 0;
  for (int i = 0; i < products_per_step && after.check_products_from > 0; ++i) {
    ProductRecord product;
    ILP_TAKE(const Found found, find_next(wiring_.store, after.check_products_from - 1, product));
    after.check_products_from = found == Found::nothing ? 0 : product.id + 1;
    if (found != Found::valid) continue;
    const bool open = product.state == ProductState::stored || product.state == ProductState::sent;
    int held = 0;
    while (held < product.layers_sent && (product.layers_held & (1U << static_cast<unsigned>(held))) != 0) ++held;
    if (!open || product.data.bytes == 0 || held == product.layers_sent) continue;
    product.layers_sent = static_cast<std::uint8_t>(held);
    product.state = ProductState::stored;
    ILP_TRY(amend(wiring_.store, product));
  }
  return changed;
}

}  // namespace ilp
