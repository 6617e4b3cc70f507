#include "fsw/components/downlink.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/components/calibration_wait.hpp"
#include "fsw/components/product_layers.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/refinement.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int64_t credit_cap_s = 10;
constexpr std::int64_t events_per_file = 64;
constexpr TimeNs events_period_ns = 120 * ns_per_s;
constexpr int acknowledgements_per_step = 16;
/// Of a pass for products that have waited too long: the rest goes where it is worth most.
constexpr std::int64_t overdue_part = 4;
/// Head of the longer file and of the refinement itself, as far as it can be known without looking at the product.
constexpr std::uint32_t refinement_overhead_bytes = 320;

bool waits(const ProductRecord& product) {
  return product.state == ProductState::stored && product.data.bytes != 0 &&
         product.data.bytes <= limits::max_product_bytes && product.layers_sent < layers_of(product);
}

PlanCandidate candidate_of(const ProductRecord& product, const ProductWorth& worth) {
  PlanCandidate candidate;
  candidate.id = product.id;
  candidate.sent = product.layers_sent;
  candidate.layers = static_cast<std::uint8_t>(layers_of(product));
  candidate.requested = worth.requested;
  double before = 0;
  for (int layers = 1; layers <= candidate.layers; ++layers) {
    const auto place = static_cast<std::size_t>(layers - 1);
    std::uint32_t bytes = bytes_to(product, layers);
    if (candidate.sent > 0) {
      const std::uint32_t down = bytes_to(product, candidate.sent);
      bytes = layers > candidate.sent ? bytes - down + refinement_overhead_bytes : 0;
    }
    candidate.bytes[place] = bytes;
    const double own = layers_worth(product, worth, layers);
    // More layers are never worth less, whatever a measured quality says.
    candidate.worth[place] = own > before ? own : before;
    before = candidate.worth[place];
  }
  return candidate;
}

}  // namespace

constexpr CheckpointForm Downlink::checkpoint = checkpoint_form<State>(ComponentId::downlink, 2);

Downlink::Downlink(Store& store, Link& link, Clock& clock, const MissionParameters& mission)
    : store_(store), link_(link), clock_(clock), mission_(mission), file_(store, link) {}

Status Downlink::restore() {
  asked_through_ = 0;
  const Status status = restore_checkpoint(store_, checkpoint, cursor_, state_);
  begin_ids<DownlinkRecord>(store_, state_.last_downlink_id);
  begin_ids<KeyframeRecord>(store_, state_.records_through);
  begin_ids<KeyframeRecord>(store_, state_.points_through);
  begin_ids<EventRecord>(store_, state_.events_through);
  begin_ids<KeyframeRecord>(store_, state_.event_files);
  return status;
}

void Downlink::credit(State& after, const Contact& contact) {
  const TimeNs now = clock_.now();
  const auto rate = static_cast<std::int64_t>(mission_.link_bytes_per_s);
  // After a restart mission time may begin again: the link must not wait until it has caught up.
  if (now < after.credited_ns) after.credited_ns = now;
  const std::int64_t elapsed_ms = (now - after.credited_ns) / ns_per_ms;
  if (elapsed_ms > 0) {
    const TimeNs until = after.credited_ns + elapsed_ms * ns_per_ms;
    const std::int64_t contact_ms = contact_between(mission_, after.credited_ns, until) / ns_per_ms;
    after.credit_bytes += rate * (contact_ms < 1000 * credit_cap_s ? contact_ms : 1000 * credit_cap_s) / 1000;
    if (after.credit_bytes > rate * credit_cap_s) after.credit_bytes = rate * credit_cap_s;
    after.credited_ns = until;
  }
  // Without passes the link goes on behind the window.
  const TimeNs left_ns = mission_.pass_period_s > 0 ? contact.end_ns - now : continuous_window_ns;
  room_bytes_ = contact.open ? after.credit_bytes + rate * (left_ns / ns_per_ms) / 1000 : 0;
}

Status Downlink::begin_pass(State& after, const Contact& contact, bool& begun) {
  begun = contact.open && contact.pass != after.pass;
  if (!begun) return {};
  after.pass = contact.pass;
  after.pass_bytes = 0;
  after.overdue_bytes = 0;
  // What a pass did not use is lost, what it took too much is owed.
  if (mission_.pass_period_s > 0 && after.credit_bytes > 0) after.credit_bytes = 0;
  for (std::size_t i = after.product_at_pass.size(); --i > 0;) after.product_at_pass[i] = after.product_at_pass[i - 1];
  ProductRecord newest;
  const Status any = last(store_, newest);
  if (any.is(StatusCode::not_found)) return {};
  ILP_TRY(any);
  after.product_at_pass[0] = newest.id;
  return {};
}

bool Downlink::fits(const State& after, std::int64_t bytes) const {
  // What is larger than a whole pass would never go: a pass may begin with it, and those behind it pay.
  return bytes <= room_bytes_ || after.pass_bytes == 0 || mission_.pass_period_s <= 0;
}

Status Downlink::open(const char* name) {
  // A store that takes nothing could not remember that the file has gone, and it would go again and again.
  ILP_TRY(save_checkpoint(store_, checkpoint, cursor_, state_));
  return file_.begin(name);
}

Status Downlink::close_file(DownlinkRecord sent, State& after) {
  ILP_TRY(file_.end());
  sent.id = after.last_downlink_id + 1;
  sent.bytes = file_.bytes();
  sent.crc32 = file_.crc();
  sent.sent_ns = clock_.now();
  sent.records_through = after.records_through;
  sent.points_through = after.points_through;
  copy_text(sent.name, file_.name());
  after.last_downlink_id = sent.id;
  after.credit_bytes -= sent.bytes;
  after.pass_bytes += sent.bytes;
  return put(store_, sent);
}

Status Downlink::send_records(std::int64_t keyframe_id, State& after) {
  KeyframeRecord keyframe;
  ILP_TRY(get(store_, keyframe_id, keyframe));
  FixedText<32> name;
  name.add("records-").add(keyframe_id, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(file_.write_records_head());
  PoseRecord pose;
  const Status posed = get(store_, keyframe_id, pose);
  if (!posed.ok() && !posed.is(StatusCode::not_found)) return posed;
  ILP_TRY(file_.write_if_present<CameraRecord>(camera_id_of(pose)));
  ILP_TRY(file_.write_if_present<StripRecord>(keyframe.strip_id));
  ILP_TRY(file_.write_record(keyframe));
  ILP_TRY(file_.write_if_present<OverlapRecord>(keyframe.frame_id));
  if (posed.ok()) ILP_TRY(file_.write_record(pose));
  ILP_TRY(file_.write_if_present<CalibrationRecord>(keyframe_id));
  DepthRecord depth;
  const Status found = get(store_, keyframe_id, depth);
  if (found.ok()) {
    depth.values.bytes = 0;
    depth.sigma.bytes = 0;
    ILP_TRY(file_.write_record(depth));
    ILP_TRY(file_.write_blob_of(record_info<DepthRecord>(), "mask", keyframe_id, depth.mask.bytes));
  } else if (!found.is(StatusCode::not_found)) {
    return found;
  }
  ILP_TRY(file_.write_if_present<RichnessRecord>(keyframe_id));
  ILP_TRY(write_products_of(keyframe_id));
  ILP_TRY(file_.write_records_tail());
  after.records_through = keyframe_id;
  DownlinkRecord sent;
  sent.kind = DownlinkKind::records;
  sent.subject_id = keyframe_id;
  return close_file(sent, after);
}

Status Downlink::write_products_of(std::int64_t keyframe_id) {
  for (std::int64_t kind = 0; kind < static_cast<std::int64_t>(ProductKind::count); ++kind) {
    ProductRecord product;
    const Status found = get(store_, product_id(keyframe_id, static_cast<ProductKind>(kind)), product);
    if (found.is(StatusCode::not_found)) continue;
    ILP_TRY(found);
    product.data.bytes = 0;
    ILP_TRY(file_.write_record(product));
  }
  return {};
}

Status Downlink::write_refinement(const ProductRecord& product, std::span<const std::uint8_t> longer, int last_layer) {
  LayerPieces pieces;
  ILP_TRY(compare_layers(longer, product.layers_sent, pieces));
  RefinementHeader header;
  header.product_id = product.id;
  header.first_layer = static_cast<std::uint8_t>(product.layers_sent + 1);
  header.last_layer = static_cast<std::uint8_t>(last_layer);
  header.shorter_bytes = static_cast<std::uint32_t>(pieces.shorter_bytes);
  header.bytes = static_cast<std::uint32_t>(longer.size());
  header.crc32 = crc32(longer);
  header.same_head = static_cast<std::uint32_t>(pieces.same_head);
  header.head_end = static_cast<std::uint32_t>(pieces.head_end);
  header.shorter_data = static_cast<std::uint32_t>(pieces.shorter_data);
  header.same_data = static_cast<std::uint32_t>(pieces.same_data);
  std::array<std::uint8_t, refinement_header_bytes> head{};
  write_refinement_header(header, head);
  FixedText<32> name;
  name.add("refine-").add(product.keyframe_id, 6).add("-").add(product_kind_name(product.kind));
  name.add("-").add(header.first_layer, 1).add("-").add(header.last_layer, 1).add(".ilr");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(file_.write(head));
  ILP_TRY(file_.write(longer.subspan(pieces.same_head, pieces.head_end - pieces.same_head)));
  ILP_TRY(file_.write(longer.subspan(pieces.head_end + pieces.same_data)));
  return file_.write_u32(file_.crc());
}

Status Downlink::send_layers(const ProductRecord& product, int last_layer, State& after) {
  ILP_ASSERT(product.data.bytes <= product_.size(), product.data.bytes);
  const std::span<std::uint8_t> whole{product_.data(), product.data.bytes};
  ILP_TRY(store_.read_blob(record_info<ProductRecord>(), "data", product.id, 0, whole));
  ProductRecord changed = product;
  std::size_t bytes = whole.size();
  // What is stored must be what the compressor made: memory and disk may have been hit.
  bool damaged = crc32(whole) != product.crc32;
  const int layers = layers_of(product);
  if (!damaged && last_layer < layers) damaged = !truncate_to_layers(whole, last_layer, bytes).ok();
  if (damaged) {
    event_ = {StatusCode::product_damaged, product.id};
    changed.state = ProductState::dropped;
    return put(store_, changed);
  }
  if (product.layers_sent == 0) {
    FixedText<32> name;
    name.add("product-").add(product.keyframe_id, 6).add("-").add(product_kind_name(product.kind)).add(".jp2");
    ILP_TRY(open(name.c_str()));
    ILP_TRY(file_.write(whole.first(bytes)));
  } else {
    ILP_TRY(write_refinement(product, whole.first(bytes), last_layer));
  }
  DownlinkRecord sent;
  sent.kind = DownlinkKind::product;
  sent.subject_id = product.id;
  sent.first_layer = static_cast<std::uint8_t>(product.layers_sent + 1);
  sent.last_layer = static_cast<std::uint8_t>(last_layer);
  ILP_TRY(close_file(sent, after));
  changed.layers_sent = static_cast<std::uint8_t>(last_layer);
  changed.state = last_layer >= layers ? ProductState::sent : ProductState::stored;
  return put(store_, changed);
}

Status Downlink::find_requests() {
  requests_.clear();
  CommandRecord command;
  std::int64_t id = 0;
  Status found = next(store_, id, command);
  for (; found.ok(); found = next(store_, id, command)) {
    id = command.id;
    if (command.kind != CommandKind::refine || requested(command.keyframe_id)) continue;
    if (requests_.push_back(command.keyframe_id)) continue;
    for (std::size_t i = 0; i + 1 < requests_.size(); ++i) requests_[i] = requests_[i + 1];
    requests_.back() = command.keyframe_id;
  }
  return found.is(StatusCode::not_found) ? Status{} : found;
}

bool Downlink::requested(std::int64_t keyframe_id) const {
  for (const std::int64_t id : requests_) {
    if (id == keyframe_id) return true;
  }
  return false;
}

Status Downlink::next_waiting(const State& after, ProductRecord& product, bool& found) {
  found = false;
  for (;;) {
    const Status any = next(store_, product.id, product);
    if (any.is(StatusCode::not_found)) return {};
    ILP_TRY(any);
    // Until the image is there, the records of the keyframe have not gone.
    if (product.keyframe_id > after.records_through) return {};
    found = waits(product);
    if (found) return {};
  }
}

Status Downlink::gather(const State& after) {
  ILP_TRY(find_requests());
  candidates_.clear();
  ProductRecord product;
  RichnessRecord richness;
  for (;;) {
    bool found = false;
    ILP_TRY(next_waiting(after, product, found));
    if (!found) return {};
    if (richness.id != product.keyframe_id) {
      const Status rated = get(store_, product.keyframe_id, richness);
      if (rated.is(StatusCode::not_found)) richness = {};
      if (!rated.ok() && !rated.is(StatusCode::not_found)) return rated;
    }
    constexpr double usual_pixels = 640.0 * 480.0;
    ProductWorth worth;
    // The plan's priority has more to say than the index alone: a depth map goes before its image.
    worth.richness = product.priority;
    worth.newly_seen_share = richness.mask_fraction;
    worth.newly_seen_px = richness.mask_fraction * usual_pixels;
    worth.requested = requested(product.keyframe_id);
    candidates_.offer(candidate_of(product, worth));
  }
}

Status Downlink::send_planned(State& after, bool& sent) {
  ILP_TRY(gather(after));
  const std::span<const PlanCandidate> candidates = candidates_.all();
  plan_pass(candidates, room_bytes_ > 0 ? static_cast<std::uint64_t>(room_bytes_) : 0, workspace_, plan_);
  std::int64_t id = 0;
  int last_layer = 0;
  if (!plan_.files.empty()) {
    id = plan_.files[0].id;
    last_layer = plan_.files[0].last_layer;
  } else {
    // Nothing fits: where the pass has only begun, what is larger than it goes all the same.
    double best = 0;
    for (const PlanCandidate& candidate : candidates) {
      const double efficiency = best_efficiency(candidate);
      if ((id != 0 && efficiency <= best) || !fits(after, candidate.bytes[candidate.sent])) continue;
      best = efficiency;
      id = candidate.id;
      last_layer = candidate.sent + 1;
    }
  }
  if (id == 0) return {};
  ProductRecord product;
  ILP_TRY(get(store_, id, product));
  sent = true;
  return send_layers(product, last_layer, after);
}

Status Downlink::send_overdue(State& after, bool& sent) {
  const auto passes = static_cast<std::size_t>(mission_.overdue_passes);
  const std::int64_t newest =
      after.product_at_pass[passes < limits::max_overdue_passes ? passes : limits::max_overdue_passes];
  ProductRecord product;
  std::int64_t id = 0;
  for (Status found = next(store_, id, product); id < newest; found = next(store_, id, product)) {
    if (found.is(StatusCode::not_found)) return {};
    ILP_TRY(found);
    id = product.id;
    if (id > newest || !waits(product) || product.layers_sent != 0) continue;
    const std::int64_t pass_bytes = after.pass_bytes + (room_bytes_ > 0 ? room_bytes_ : 0);
    const std::int64_t bytes = bytes_to(product, 1);
    const bool first = after.overdue_bytes == 0;
    if (!first && (after.overdue_bytes + bytes) * overdue_part > pass_bytes) return {};
    if (!fits(after, bytes)) return {};
    const std::int64_t before = after.pass_bytes;
    sent = true;
    // Records go in order; those of an older keyframe have waited as long.
    const bool known = product.keyframe_id <= after.records_through;
    ILP_TRY(known ? send_layers(product, 1, after) : send_records(after.records_through + 1, after));
    after.overdue_bytes += after.pass_bytes - before;
    return {};
  }
  return {};
}

Status Downlink::send_in_order(State& after, bool& sent) {
  ProductRecord product;
  bool found = false;
  ILP_TRY(next_waiting(after, product, found));
  if (!found) return {};
  const int layers = layers_of(product);
  if (!fits(after, bytes_to(product, layers))) return {};
  sent = true;
  return send_layers(product, layers, after);
}

Status Downlink::send_next_records(State& after, bool& sent) {
  constexpr std::int64_t usual_bytes = 3000;
  ProductRecord product;
  const std::int64_t keyframe_id = after.records_through + 1;
  // The compressor works in order: an image of this or a later keyframe means that this one is done.
  const Status found = next(store_, product_id(keyframe_id, ProductKind::image) - 1, product);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  if (!fits(after, usual_bytes)) return {};
  sent = true;
  return send_records(keyframe_id, after);
}

Status Downlink::send_next_points(State& after, bool& sent) {
  StructureRecord structure;
  for (;;) {
    const Status found = next(store_, after.points_through, structure);
    if (found.is(StatusCode::not_found)) return {};
    ILP_TRY(found);
    if (structure.id > after.records_through) return {};
    if (structure.points.bytes != 0) break;
    after.points_through = structure.id;
  }
  if (!fits(after, structure.points.bytes)) return {};
  sent = true;
  FixedText<32> name;
  name.add("points-").add(structure.id, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(file_.write_records_head());
  ILP_TRY(file_.write_record(structure));
  ILP_TRY(file_.write_blob_of(record_info<StructureRecord>(), "points", structure.id, structure.points.bytes));
  ILP_TRY(file_.write_records_tail());
  after.points_through = structure.id;
  DownlinkRecord file;
  file.kind = DownlinkKind::points;
  file.subject_id = structure.id;
  return close_file(file, after);
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
  ILP_TRY(file_.write_records_head());
  EventRecord event;
  std::int64_t through = after.events_through;
  for (std::int64_t i = 0; i < events_per_file && next(store_, through, event).ok(); ++i) {
    through = event.id;
    ILP_TRY(file_.write_record(event));
  }
  for (std::int64_t id = 1; id <= static_cast<std::int64_t>(ComponentId::count); ++id) {
    ILP_TRY(file_.write_if_present<ComponentRecord>(id));
  }
  ILP_TRY(file_.write_newest<StartRecord>());
  ILP_TRY(file_.write_if_present<TimingRecord>(1));
  ILP_TRY(file_.write_if_present<StorageRecord>(1));
  ILP_TRY(file_.write_newest<CalibrationRecord>());
  ILP_TRY(file_.write_newest<CalibrationCheckRecord>());
  ILP_TRY(file_.write_records_tail());
  after.events_through = through;
  after.event_files += 1;
  after.events_sent_ns = clock_.now();
  after.housekeeping_steps = housekeeping_steps;
  DownlinkRecord sent;
  sent.kind = DownlinkKind::records;
  sent.subject_id = -after.event_files;
  return close_file(sent, after);
}

Status Downlink::send_events_if_due(State& after, bool& sent) {
  constexpr std::int64_t usual_bytes = 8000;
  EventRecord newest;
  const bool new_events = last(store_, newest).ok() && newest.id > after.events_through;
  std::int64_t housekeeping_steps = 0;
  ILP_TRY(housekeeping_fingerprint(housekeeping_steps));
  const bool enough = new_events && newest.id - after.events_through >= events_per_file;
  const bool old = new_events && clock_.now() - after.events_sent_ns >= events_period_ns;
  if (!enough && !old && housekeeping_steps == after.housekeeping_steps) return {};
  if (!fits(after, usual_bytes)) return {};
  sent = true;
  return send_events(housekeeping_steps, after);
}

Status Downlink::send_next(State& after, bool& sent) {
  sent = false;
  drained_ = false;
  const Contact contact = contact_at(mission_, clock_.now());
  if (!contact.open || after.credit_bytes < 0 || mission_.link_bytes_per_s <= 0) return {};
  if (mission_.downlink_order != 0) {
    ILP_TRY(send_in_order(after, sent));
    if (!sent) ILP_TRY(send_next_records(after, sent));
  } else {
    ILP_TRY(send_overdue(after, sent));
    if (!sent) ILP_TRY(send_next_records(after, sent));
    if (!sent) ILP_TRY(send_planned(after, sent));
  }
  if (!sent) ILP_TRY(send_next_points(after, sent));
  if (!sent) ILP_TRY(send_events_if_due(after, sent));
  if (!sent) drained_ = after.acknowledged_through == after.last_downlink_id;
  return {};
}

Status Downlink::send_in_contact(State& after, bool& sent) {
  const State before = after;
  const Status status = send_next(after, sent);
  if (status.is(StatusCode::transfer_queue_full)) {
    after = before;
    sent = false;
    return {};
  }
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

Status Downlink::hear_product(const DownlinkRecord& record) {
  ProductRecord product;
  const Status found = get(store_, record.subject_id, product);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  for (unsigned layer = record.first_layer; layer >= 1 && layer <= record.last_layer; ++layer) {
    product.layers_held = static_cast<std::uint8_t>(product.layers_held | (1U << (layer - 1)));
  }
  if (product.layers_sent >= layers_of(product) && all_held(product)) product.state = ProductState::acknowledged;
  return put(store_, product);
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
        if (record.kind == DownlinkKind::product) ILP_TRY(hear_product(record));
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
  const Contact contact = contact_at(mission_, clock_.now());
  bool heard = false;
  bool sent = false;
  bool begun = false;
  Transaction transaction(store_);
  Status status = transaction.begin();
  if (status.ok()) status = begin_pass(after, contact, begun);
  if (status.ok()) credit(after, contact);
  if (status.ok()) status = hear(after, heard);
  if (status.ok()) status = send_in_contact(after, sent);
  if (!status.ok()) return {status, false};
  if (heard || sent || begun) {
    status = save_checkpoint(store_, checkpoint, cursor_, after);
    if (status.ok()) status = transaction.commit();
    if (!status.ok()) return {status, false};
  }
  state_ = after;
  return {event_, sent};
}

}  // namespace ilp
