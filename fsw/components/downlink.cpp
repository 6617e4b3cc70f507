#include "fsw/components/downlink.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/components/calibration_wait.hpp"
#include "fsw/records/serial.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t layout = 1;
constexpr std::int64_t credit_cap_s = 10;
constexpr std::int64_t events_per_file = 64;
constexpr TimeNs events_period_ns = 120 * ns_per_s;
constexpr int acknowledgements_per_step = 16;
constexpr std::uint8_t end_of_entries = 255;

const char* kind_name(ProductKind kind) {
  return kind == ProductKind::image ? "image" : "depth";
}

}  // namespace

Downlink::Downlink(Store& store, Link& link, Clock& clock, const MissionParameters& mission)
    : store_(store), link_(link), clock_(clock), mission_(mission) {}

Status Downlink::restore() {
  asked_through_ = 0;
  return restore_checkpoint(store_, ComponentId::downlink, cursor_, layout, state_);
}

void Downlink::credit(State& after) {
  const TimeNs now = clock_.now();
  const auto rate = static_cast<std::int64_t>(mission_.link_bytes_per_s);
  // After a restart mission time may begin again: the link must not wait until it has caught up.
  if (now < after.credited_ns) after.credited_ns = now;
  const std::int64_t elapsed_ms = (now - after.credited_ns) / ns_per_ms;
  if (elapsed_ms <= 0) return;
  after.credit_bytes += rate * (elapsed_ms < 1000 * credit_cap_s ? elapsed_ms : 1000 * credit_cap_s) / 1000;
  if (after.credit_bytes > rate * credit_cap_s) after.credit_bytes = rate * credit_cap_s;
  after.credited_ns += elapsed_ms * ns_per_ms;
}

Status Downlink::open(const char* name) {
  // A store that takes nothing could not remember that the file has gone, and it would go again and again.
  ILP_TRY(save_checkpoint(store_, ComponentId::downlink, cursor_, layout, state_));
  copy_text(name_, name);
  bytes_ = 0;
  crc_ = 0;
  return link_.begin_file(name);
}

Status Downlink::write(std::span<const std::uint8_t> bytes) {
  crc_ = crc32(bytes, crc_);
  bytes_ += static_cast<std::uint32_t>(bytes.size());
  return link_.write(bytes);
}

Status Downlink::write_u8(std::uint8_t value) {
  return write({&value, 1});
}

Status Downlink::write_u32(std::uint32_t value) {
  std::uint8_t bytes[4];
  for (unsigned i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
  return write(bytes);
}

Status Downlink::write_entry(const RecordInfo& info, const void* record) {
  const std::size_t size = serial_bytes(info);
  ILP_ASSERT(size <= chunk_bytes, size);
  ILP_TRY(write_u8(static_cast<std::uint8_t>(info.type)));
  ILP_TRY(write_u8(static_cast<std::uint8_t>(size & 0xFFU)));
  ILP_TRY(write_u8(static_cast<std::uint8_t>(size >> 8U)));
  ILP_TRY(serialize(info, record, chunk_));
  return write({chunk_, size});
}

Status Downlink::write_blob_of(const RecordInfo& info, const char* field, std::int64_t id, std::uint32_t bytes) {
  for (std::size_t offset = 0; offset < bytes; offset += chunk_bytes) {
    const std::size_t size = bytes - offset < chunk_bytes ? bytes - offset : chunk_bytes;
    ILP_TRY(store_.read_blob(info, field, id, offset, {chunk_, size}));
    ILP_TRY(write({chunk_, size}));
  }
  return {};
}

template <typename Record>
Status Downlink::write_if_present(std::int64_t id) {
  Record record;
  const Status found = get(store_, id, record);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  return write_entry(record_info<Record>(), &record);
}

template <typename Record>
Status Downlink::write_newest() {
  Record record;
  const Status found = last(store_, record);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  return write_entry(record_info<Record>(), &record);
}

Status Downlink::close_file(DownlinkKind kind, std::int64_t subject_id, State& after) {
  ILP_TRY(link_.end_file());
  DownlinkRecord sent;
  sent.id = after.last_downlink_id + 1;
  sent.kind = kind;
  sent.subject_id = subject_id;
  sent.bytes = bytes_;
  sent.crc32 = crc_;
  sent.sent_ns = clock_.now();
  sent.records_through = after.records_through;
  copy_text(sent.name, name_);
  after.last_downlink_id = sent.id;
  after.credit_bytes -= bytes_;
  return put(store_, sent);
}

Status Downlink::send_records(std::int64_t keyframe_id, State& after) {
  KeyframeRecord keyframe;
  ILP_TRY(get(store_, keyframe_id, keyframe));
  FixedText<32> name;
  name.add("records-").add(keyframe_id, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  constexpr std::uint8_t magic[] = {'I', 'L', 'P', 'R'};
  ILP_TRY(write(magic));
  ILP_TRY(write_u32(static_cast<std::uint32_t>(schema_version)));
  PoseRecord pose;
  const Status posed = get(store_, keyframe_id, pose);
  if (!posed.ok() && !posed.is(StatusCode::not_found)) return posed;
  ILP_TRY(write_if_present<CameraRecord>(camera_id_of(pose)));
  ILP_TRY(write_if_present<StripRecord>(keyframe.strip_id));
  ILP_TRY(write_entry(record_info<KeyframeRecord>(), &keyframe));
  ILP_TRY(write_if_present<OverlapRecord>(keyframe.frame_id));
  if (posed.ok()) ILP_TRY(write_entry(record_info<PoseRecord>(), &pose));
  ILP_TRY(write_if_present<CalibrationRecord>(keyframe_id));

  StructureRecord structure;
  Status found = get(store_, keyframe_id, structure);
  if (found.ok()) {
    ILP_TRY(write_entry(record_info<StructureRecord>(), &structure));
    ILP_TRY(write_blob_of(record_info<StructureRecord>(), "points", keyframe_id, structure.points.bytes));
  } else if (!found.is(StatusCode::not_found)) {
    return found;
  }
  DepthRecord depth;
  found = get(store_, keyframe_id, depth);
  if (found.ok()) {
    depth.values.bytes = 0;
    depth.sigma.bytes = 0;
    ILP_TRY(write_entry(record_info<DepthRecord>(), &depth));
    ILP_TRY(write_blob_of(record_info<DepthRecord>(), "mask", keyframe_id, depth.mask.bytes));
  } else if (!found.is(StatusCode::not_found)) {
    return found;
  }
  ILP_TRY(write_if_present<RichnessRecord>(keyframe_id));
  for (std::int64_t kind = 0; kind < static_cast<std::int64_t>(ProductKind::count); ++kind) {
    ProductRecord product;
    found = get(store_, product_id(keyframe_id, static_cast<ProductKind>(kind)), product);
    if (found.is(StatusCode::not_found)) continue;
    ILP_TRY(found);
    product.data.bytes = 0;
    ILP_TRY(write_entry(record_info<ProductRecord>(), &product));
  }
  ILP_TRY(write_u8(end_of_entries));
  ILP_TRY(write_u32(crc_));
  after.records_through = keyframe_id;
  return close_file(DownlinkKind::records, keyframe_id, after);
}

Status Downlink::send_product(const ProductRecord& product, State& after) {
  FixedText<32> name;
  name.add("product-").add(product.keyframe_id, 6).add("-").add(kind_name(product.kind)).add(".jp2");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(write_blob_of(record_info<ProductRecord>(), "data", product.id, product.data.bytes));
  // What is stored must be what the compressor made: memory and disk may have been hit.
  ProductRecord changed = product;
  if (crc_ != product.crc32) {
    event_ = {StatusCode::product_damaged, product.id};
    changed.state = ProductState::dropped;
    return put(store_, changed);
  }
  ILP_TRY(close_file(DownlinkKind::product, product.id, after));
  changed.state = ProductState::sent;
  return put(store_, changed);
}

Status Downlink::housekeeping_fingerprint(std::int64_t& steps) {
  steps = 0;
  ComponentRecord record;
  std::int64_t id = 0;
  for (Status found = next(store_, id, record); found.ok(); found = next(store_, id, record)) {
    id = record.id;
    steps += record.steps;
  }
  return {};
}

Status Downlink::send_events(std::int64_t housekeeping_steps, State& after) {
  FixedText<32> name;
  name.add("events-").add(after.event_files + 1, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  constexpr std::uint8_t magic[] = {'I', 'L', 'P', 'R'};
  ILP_TRY(write(magic));
  ILP_TRY(write_u32(static_cast<std::uint32_t>(schema_version)));
  EventRecord event;
  std::int64_t through = after.events_through;
  for (std::int64_t i = 0; i < events_per_file && next(store_, through, event).ok(); ++i) {
    through = event.id;
    ILP_TRY(write_entry(record_info<EventRecord>(), &event));
  }
  for (std::int64_t id = 1; id <= static_cast<std::int64_t>(ComponentId::count); ++id) {
    ILP_TRY(write_if_present<ComponentRecord>(id));
  }
  ILP_TRY(write_if_present<StorageRecord>(1));
  ILP_TRY(write_newest<CalibrationRecord>());
  ILP_TRY(write_newest<CalibrationCheckRecord>());
  ILP_TRY(write_u8(end_of_entries));
  ILP_TRY(write_u32(crc_));
  after.events_through = through;
  after.event_files += 1;
  after.events_sent_ns = clock_.now();
  after.housekeeping_steps = housekeeping_steps;
  return close_file(DownlinkKind::records, -after.event_files, after);
}

Status Downlink::send_next(State& after, bool& sent) {
  sent = false;
  drained_ = false;
  if (after.credit_bytes < 0 || mission_.link_bytes_per_s <= 0) return {};

  ProductRecord product;
  const std::int64_t keyframe_id = after.records_through + 1;
  // The compressor works in order: an image of this or a later keyframe means that this one is done.
  Status found = next(store_, product_id(keyframe_id, ProductKind::image) - 1, product);
  if (found.ok()) {
    sent = true;
    return send_records(keyframe_id, after);
  }
  if (!found.is(StatusCode::not_found)) return found;

  ProductRecord best;
  bool any = false;
  std::int64_t id = 0;
  for (found = next(store_, id, product); found.ok(); found = next(store_, id, product)) {
    id = product.id;
    // Until the image is there, the records of the keyframe have not gone.
    if (product.keyframe_id > after.records_through) break;
    if (product.state != ProductState::stored || product.data.bytes == 0) continue;
    if (!any || product.priority > best.priority) best = product;
    any = true;
  }
  if (any) {
    sent = true;
    return send_product(best, after);
  }

  EventRecord newest;
  const bool new_events = last(store_, newest).ok() && newest.id > after.events_through;
  std::int64_t housekeeping_steps = 0;
  ILP_TRY(housekeeping_fingerprint(housekeeping_steps));
  const bool enough = new_events && newest.id - after.events_through >= events_per_file;
  const bool old = new_events && clock_.now() - after.events_sent_ns >= events_period_ns;
  if (enough || old || housekeeping_steps != after.housekeeping_steps) {
    sent = true;
    return send_events(housekeeping_steps, after);
  }
  drained_ = after.acknowledged_through == after.last_downlink_id;
  return {};
}

Status Downlink::send_in_contact(State& after, bool& sent) {
  const State before = after;
  const Status status = send_next(after, sent);
  // The store answers not_found where there is nothing: only a link is not ready.
  if (status.is(StatusCode::not_ready)) {
    after = before;
    sent = false;
    if (contact_lost_) return {};
    contact_lost_ = true;
    contact_lost_ns_ = clock_.now();
    event_ = {StatusCode::link_lost, after.last_downlink_id};
    return {};
  }
  if (status.ok() && sent && contact_lost_) {
    contact_lost_ = false;
    if (event_.ok()) event_ = {StatusCode::link_restored, (clock_.now() - contact_lost_ns_) / ns_per_ms};
  }
  return status;
}

Status Downlink::hear(State& after, bool& heard) {
  heard = false;
  DownlinkRecord record;
  // A confirmation that never comes must not hide those behind it: in turns over all that is not confirmed.
  if (asked_through_ < after.acknowledged_through) asked_through_ = after.acknowledged_through;
  std::int64_t id = asked_through_;
  bool all_before = id == after.acknowledged_through;
  int asked = 0;
  for (; asked < acknowledgements_per_step && next(store_, id, record).ok(); ++asked) {
    id = record.id;
    if (record.acknowledged_ns == 0) {
      std::uint32_t bytes = 0;
      std::uint32_t crc = 0;
      const Status answer = link_.acknowledged(record.name, bytes, crc);
      // A damaged copy on the ground is not an acknowledgement; the file stays on board.
      if (answer.ok() && bytes == record.bytes && crc == record.crc32) {
        record.acknowledged_ns = clock_.now();
        heard = true;
        ILP_TRY(put(store_, record));
        ProductRecord product;
        if (record.kind == DownlinkKind::product && get(store_, record.subject_id, product).ok()) {
          product.state = ProductState::acknowledged;
          ILP_TRY(put(store_, product));
        }
      }
    }
    all_before = all_before && record.acknowledged_ns != 0;
    if (all_before) after.acknowledged_through = id;
  }
  asked_through_ = asked < acknowledgements_per_step ? after.acknowledged_through : id;
  return {};
}

StepResult Downlink::step(TimeNs deadline) {
  static_cast<void>(deadline);
  State after = state_;
  event_ = {};
  credit(after);
  bool heard = false;
  bool sent = false;
  Transaction transaction(store_);
  Status status = transaction.begin();
  if (status.ok()) status = hear(after, heard);
  if (status.ok()) status = send_in_contact(after, sent);
  if (!status.ok()) return {status, false};
  if (heard || sent) {
    status = save_checkpoint(store_, ComponentId::downlink, cursor_, layout, after);
    if (status.ok()) status = transaction.commit();
    if (!status.ok()) return {status, false};
  }
  state_ = after;
  return {event_, sent};
}

}  // namespace ilp
