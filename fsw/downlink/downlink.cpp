#include "fsw/downlink/downlink.hpp"

#include "fsw/base/text.hpp"
#include "fsw/shared/product_layers.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int64_t credit_cap_s = 10;
constexpr TimeNs events_period_ns = 120 * ns_per_s;
constexpr int acknowledgements_per_step = 16;
/// Part of a pass for products that have waited too long. The rest is used by worth.
constexpr std::int64_t overdue_part = 4;
/// Head of the longer file and of the refinement itself, as far as it is known without the product's bytes.
constexpr std::uint32_t refinement_overhead_bytes = 320;
/// More bytes than any link carries, and few enough that sums of them do not overflow.
constexpr std::int64_t no_limit_bytes = std::int64_t{1} << 50U;
constexpr std::int64_t usual_records_bytes = 3000;
constexpr std::int64_t usual_events_bytes = 8000;
/// Faults of one file until it is abandoned: faults that may pass (in half an hour), and permanent ones.
constexpr std::uint32_t most_passing_faults = 12;
constexpr std::uint32_t most_lasting_faults = 3;
/// After a fault of the store, this many confirmations are committed one by one.
constexpr int heard_alone = 16;

/// A slower link counts as one byte per second, so that it does not stop.
std::int64_t link_rate(const MissionParameters& mission) {
  if (mission.link_bytes_per_s <= 0) return 0;
  return mission.link_bytes_per_s < 1 ? 1 : static_cast<std::int64_t>(mission.link_bytes_per_s);
}

/// Bytes that a link carries in a time, limited to no_limit_bytes.
std::int64_t bytes_in(std::int64_t rate, TimeNs time) {
  const std::int64_t seconds = time / ns_per_s;
  if (rate > 0 && seconds >= no_limit_bytes / rate) return no_limit_bytes;
  return rate * seconds + rate * (time % ns_per_s / ns_per_ms) / 1000;
}

bool can_go(const ProductRecord& product) {
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

constexpr CheckpointForm Downlink::checkpoint = checkpoint_form<State>(component_id);

Downlink::Downlink(Tables store, Link& link, Clock& clock, const MissionParameters& mission)
    : store_(store), link_(link), clock_(clock), mission_(mission), file_(store, link) {}

Status Downlink::restore() {
  asked_through_ = 0;
  hear_alone_ = 0;
  set_aside_.clear();
  const Status news = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(news)) return news;
  ILP_TRY(catch_up());
  return news;
}

Status Downlink::catch_up() {
  begin_ids<DownlinkRecord>(store_, state_.last_downlink_id);
  begin_ids<DownlinkRecord>(store_, state_.acknowledged_through);
  begin_ids<KeyframeRecord>(store_, state_.records_through);
  begin_ids<KeyframeRecord>(store_, state_.points_through);
  begin_ids<EventRecord>(store_, state_.events_through);
  begin_ids<KeyframeRecord>(store_, state_.event_files);
  DownlinkRecord record;
  for (;;) {
    Found found{};
    ILP_TRY(find_next(store_, state_.last_downlink_id, record, found));
    if (found == Found::nothing) break;
    state_.last_downlink_id = record.id;
    if (found == Found::damaged) continue;
    if (state_.records_through < record.records_through) state_.records_through = record.records_through;
    if (state_.points_through < record.points_through) state_.points_through = record.points_through;
    // Its number is in use; its events are sent once more.
    if (record.kind == DownlinkKind::records && record.subject_id <= 0) ++state_.event_files;
  }
  const Status newest = last(store_, record);
  newest_sent_ns_ = newest.ok() ? record.sent_ns : 0;
  return is_transient(newest) ? newest : Status{};
}

void Downlink::credit(State& after, const Contact& contact) {
  const TimeNs now = clock_.now();
  const std::int64_t rate = link_rate(mission_);
  // After a restart mission time may begin again, and the link must not wait until it has caught up.
  if (now < after.credited_ns) after.credited_ns = now;
  const std::int64_t elapsed_ms = (now - after.credited_ns) / ns_per_ms;
  if (elapsed_ms > 0) {
    const TimeNs until = after.credited_ns + elapsed_ms * ns_per_ms;
    const std::int64_t contact_ms = contact_between(mission_, after.credited_ns, until) / ns_per_ms;
    const std::int64_t bytes = rate * (contact_ms < 1000 * credit_cap_s ? contact_ms : 1000 * credit_cap_s) / 1000;
    after.credit_bytes += bytes;
    if (after.credit_bytes > rate * credit_cap_s) after.credit_bytes = rate * credit_cap_s;
    // On a slow link the fractions of a byte add up.
    if (bytes > 0 || contact_ms == 0) after.credited_ns = until;
  }
  // Without passes the link continues after the window.
  const TimeNs left_ns = mission_.pass_period_s > 0 ? contact.end_ns - now : continuous_window_ns;
  room_bytes_ = contact.open ? after.credit_bytes + bytes_in(rate, left_ns) : 0;
}

Status Downlink::begin_pass(State& after, const Contact& contact, bool& begun) {
  begun = contact.open && contact.pass != after.pass;
  if (!begun) return {};
  after.pass = contact.pass;
  after.pass_bytes = 0;
  after.overdue_bytes = 0;
  // The unused part of a pass is lost; an overdraft stays as a debt.
  if (mission_.pass_period_s > 0 && after.credit_bytes > 0) after.credit_bytes = 0;
  for (std::size_t i = after.product_at_pass.size(); --i > 0;) after.product_at_pass[i] = after.product_at_pass[i - 1];
  ProductRecord newest;
  const Status any = last(store_, newest);
  if (any.is(StatusCode::not_found)) return {};
  if (any.is(StatusCode::record_damaged)) newest.id = any.a;
  if (!any.is(StatusCode::record_damaged)) ILP_TRY(any);
  after.product_at_pass[0] = newest.id;
  return {};
}

bool Downlink::fits(const State& after, std::int64_t bytes) const {
  // A file that is larger than a whole pass would never be sent. A pass may begin with it, at the cost of the files
  // after it.
  return bytes <= room_bytes_ || after.pass_bytes == 0 || mission_.pass_period_s <= 0;
}

bool Downlink::may_go(const State& after, std::int64_t bytes, std::int64_t most) {
  something_waits_ = true;
  return bytes <= most && fits(after, bytes);
}

Status Downlink::find_requests() {
  requests_.clear();
  CommandRecord command;
  for (;;) {
    Found found{};
    ILP_TRY(find_next(store_, command.id, command, found));
    if (found == Found::nothing) return {};
    const bool refine = found == Found::sound && command.kind == CommandKind::refine;
    if (!refine || requested(command.keyframe_id)) continue;
    if (requests_.push_back(command.keyframe_id)) continue;
    for (std::size_t i = 0; i + 1 < requests_.size(); ++i) requests_[i] = requests_[i + 1];
    requests_.back() = command.keyframe_id;
  }
}

bool Downlink::requested(std::int64_t keyframe_id) const {
  for (const std::int64_t id : requests_) {
    if (id == keyframe_id) return true;
  }
  return false;
}

bool Downlink::rests(FileClass kind, std::int64_t id) const {
  return set_aside_.rests(static_cast<std::uint8_t>(kind), id, clock_.now());
}

bool Downlink::given_up(FileClass kind, std::int64_t id) const {
  return set_aside_.given_up(static_cast<std::uint8_t>(kind), id);
}

std::int64_t Downlink::late_one(const State& after, FileClass kind) const {
  for (const Late& late : after.late) {
    if (late.kind == kind && !rests(kind, late.id)) return late.id;
  }
  return 0;
}

bool Downlink::waits(const State& after, const ProductRecord& product) const {
  if (!can_go(product) || rests(FileClass::products, product.id)) return false;
  for (const Late& late : after.late) {
    if (late.kind == FileClass::records && late.id == product.keyframe_id) return false;
  }
  return true;
}

Status Downlink::next_waiting(const State& after, ProductRecord& product, bool& found) {
  found = false;
  for (;;) {
    Found any{};
    ILP_TRY(find_next(store_, product.id, product, any));
    if (any == Found::nothing) return {};
    if (any == Found::damaged) continue;
    // The records of a keyframe are sent after its image is made.
    if (product.keyframe_id > after.records_through) return {};
    found = waits(after, product);
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
      // Unreadable richness has no weight: the product's own priority counts.
      if (!rated.ok()) richness = {};
      if (is_transient(rated)) return rated;
    }
    constexpr double usual_pixels = 640.0 * 480.0;
    ProductWorth worth;
    // The plan's priority contains more than the index alone: a depth map goes before its image.
    worth.richness = product.priority;
    worth.newly_seen_share = richness.mask_fraction;
    worth.newly_seen_px = richness.mask_fraction * usual_pixels;
    worth.requested = requested(product.keyframe_id);
    candidates_.offer(candidate_of(product, worth));
  }
}

Status Downlink::send_planned(std::int64_t most, State& after, bool& sent) {
  ILP_TRY(gather(after));
  const std::span<const PlanCandidate> candidates = candidates_.all();
  plan_pass(candidates, room_bytes_ > 0 ? static_cast<std::uint64_t>(room_bytes_) : 0, workspace_, plan_);
  something_waits_ = something_waits_ || !candidates.empty();
  std::int64_t id = 0;
  std::int64_t bytes = 0;
  int last_layer = 0;
  if (!plan_.files.empty()) {
    id = plan_.files[0].id;
    bytes = plan_.files[0].bytes;
    last_layer = plan_.files[0].last_layer;
  } else {
    // Nothing fits. At the beginning of a pass, a file that is larger than the pass is sent.
    double best = 0;
    for (const PlanCandidate& candidate : candidates) {
      const double efficiency = best_efficiency(candidate);
      if ((id != 0 && efficiency <= best) || !fits(after, candidate.bytes[candidate.sent])) continue;
      best = efficiency;
      id = candidate.id;
      bytes = candidate.bytes[candidate.sent];
      last_layer = candidate.sent + 1;
    }
  }
  if (id == 0) return {};
  if (bytes > most) {
    after.planned_bytes = bytes;
    return {};
  }
  ProductRecord product;
  ILP_TRY(get(store_, id, product));
  return send_layers(product, last_layer, after, sent);
}

Status Downlink::send_overdue(State& after, bool& sent) {
  const std::size_t passes = mission_.overdue_passes;
  const std::int64_t newest =
      after.product_at_pass[passes < limits::max_overdue_passes ? passes : limits::max_overdue_passes];
  ProductRecord product;
  while (product.id < newest) {
    Found found{};
    ILP_TRY(find_next(store_, product.id, product, found));
    if (found == Found::nothing) return {};
    if (found == Found::damaged || product.id > newest || !waits(after, product) || product.layers_sent != 0) continue;
    const std::int64_t pass_bytes = after.pass_bytes + (room_bytes_ > 0 ? room_bytes_ : 0);
    const std::int64_t bytes = bytes_to(product, 1);
    const bool first = after.overdue_bytes == 0;
    if (!first && (after.overdue_bytes + bytes) * overdue_part > pass_bytes) return {};
    if (!fits(after, bytes)) return {};
    const std::int64_t before = after.pass_bytes;
    // Records are sent in order, and those of an older keyframe have waited as long.
    const bool known = product.keyframe_id <= after.records_through;
    ILP_TRY(known ? send_layers(product, 1, after, sent) : send_next_records(no_limit_bytes, after, sent));
    after.overdue_bytes += after.pass_bytes - before;
    return {};
  }
  return {};
}

Status Downlink::send_in_order(std::int64_t most, State& after, bool& sent) {
  ProductRecord product;
  bool found = false;
  ILP_TRY(next_waiting(after, product, found));
  if (!found) return {};
  const int layers = layers_of(product);
  const std::int64_t bytes = bytes_to(product, layers);
  if (!may_go(after, bytes, most)) {
    if (bytes > most) after.planned_bytes = bytes;
    return {};
  }
  return send_layers(product, layers, after, sent);
}

Status Downlink::send_next_records(std::int64_t most, State& after, bool& sent) {
  const std::int64_t late = late_one(after, FileClass::records);
  if (late != 0) return may_go(after, usual_records_bytes, most) ? send_records(late, after, sent) : Status{};
  // Each turn makes one more of them late.
  for (std::size_t turn = 0; turn <= max_late_files; ++turn) {
    KeyframeRecord keyframe;
    Found found{};
    ILP_TRY(find_next(store_, after.records_through, keyframe, found));
    if (found == Found::nothing) return {};
    // The compressor works in order: an image of this or a later keyframe means that this one is done.
    ProductRecord product;
    ILP_TRY(find_next(store_, product_id(keyframe.id, ProductKind::image) - 1, product, found));
    if (found == Found::nothing) return {};
    if (!rests(FileClass::records, keyframe.id)) {
      return may_go(after, usual_records_bytes, most) ? send_records(keyframe.id, after, sent) : Status{};
    }
    // It is set aside, and the files after it are sent.
    if (!after.late.push_back({FileClass::records, keyframe.id})) return {};
    after.records_through = keyframe.id;
  }
  return {};
}

Status Downlink::send_next_points(std::int64_t most, State& after, bool& sent) {
  const std::int64_t late = late_one(after, FileClass::points);
  if (late != 0) return send_points(late, most, after, sent);
  for (;;) {
    StructureRecord structure;
    Found found{};
    ILP_TRY(find_next(store_, after.points_through, structure, found));
    if (found == Found::nothing) return {};
    if (structure.id > after.records_through) return {};
    if (rests(FileClass::points, structure.id)) {
      if (!after.late.push_back({FileClass::points, structure.id})) return {};
    } else if (found == Found::damaged || structure.points.bytes != 0) {
      return send_points(structure.id, most, after, sent);
    }
    after.points_through = structure.id;
  }
}

Status Downlink::send_events_if_due(std::int64_t most, State& after, bool& sent) {
  std::int64_t housekeeping_steps = 0;
  const std::int64_t late = late_one(after, FileClass::events);
  if (late != 0) {
    if (!may_go(after, usual_events_bytes, most)) return {};
    EventRecord event;
    const Status any = next(store_, late - 1, event);
    const bool gone = any.is(StatusCode::not_found) || (any.ok() && event.id >= late + events_per_file);
    housekeeping_fingerprint(housekeeping_steps);
    if (!gone) return send_events(late - 1, true, housekeeping_steps, after, sent);
    drop_late({FileClass::events, late}, after);
  }
  EventRecord newest;
  const Status any = last(store_, newest);
  if (any.is(StatusCode::record_damaged)) newest.id = any.a;
  if (is_transient(any)) return any;
  const bool new_events = newest.id > after.events_through;
  housekeeping_fingerprint(housekeeping_steps);
  const bool enough = new_events && newest.id - after.events_through >= events_per_file;
  const bool old = new_events && clock_.now() - after.events_sent_ns >= events_period_ns;
  if (!enough && !old && housekeeping_steps == after.housekeeping_steps) return {};
  if (!may_go(after, usual_events_bytes, most)) return {};
  // Events of a file that was set aside wait. Only later ones follow them.
  if (rests(FileClass::events, after.events_through + 1)) return {};
  return send_events(after.events_through, false, housekeeping_steps, after, sent);
}

Status Downlink::send_class(FileClass kind, std::int64_t most, State& after, bool& sent) {
  switch (kind) {
    case FileClass::products:
      return mission_.downlink_order == DownlinkOrder::origin ? send_in_order(most, after, sent)
                                                              : send_planned(most, after, sent);
    case FileClass::records:
      return send_next_records(most, after, sent);
    case FileClass::points:
      return send_next_points(most, after, sent);
    default:
      return send_events_if_due(most, after, sent);
  }
}

Status Downlink::send_owed(State& after, bool& sent) {
  // With less credit the next file of the class does not fit, by the sizes known so far.
  const std::int64_t least[file_classes] = {after.planned_bytes, usual_records_bytes, 1, usual_events_bytes};
  bool tried[file_classes] = {};
  for (std::size_t turn = 0; turn < file_classes; ++turn) {
    std::size_t best = file_classes;
    for (std::size_t i = 0; i < file_classes; ++i) {
      if (tried[i] || after.owed_bytes[i] == 0 || after.owed_bytes[i] < least[i]) continue;
      if (best == file_classes || after.owed_bytes[i] > after.owed_bytes[best]) best = i;
    }
    if (best == file_classes) return {};
    tried[best] = true;
    something_waits_ = false;
    ILP_TRY(send_class(static_cast<FileClass>(best), after.owed_bytes[best], after, sent));
    if (sent) return {};
    // No file waits, so there is nothing to save credit for.
    if (!something_waits_) after.owed_bytes[best] = 0;
  }
  return {};
}

Status Downlink::send_next(State& after, bool& sent) {
  sent = false;
  drained_ = false;
  const Contact contact = contact_at(mission_, clock_.now());
  if (!contact.open || after.credit_bytes < 0 || mission_.link_bytes_per_s <= 0) return {};
  constexpr FileClass by_worth[] = {FileClass::records, FileClass::products, FileClass::points, FileClass::events};
  constexpr FileClass by_origin[] = {FileClass::products, FileClass::records, FileClass::points, FileClass::events};
  const bool in_order = mission_.downlink_order == DownlinkOrder::origin;
  if (!in_order) ILP_TRY(send_overdue(after, sent));
  if (!sent) ILP_TRY(send_owed(after, sent));
  something_waits_ = false;
  for (std::size_t i = 0; i < file_classes && !sent; ++i) {
    ILP_TRY(send_class(in_order ? by_origin[i] : by_worth[i], no_limit_bytes, after, sent));
  }
  if (sent) return {};
  // Entries that were due and did not appear no longer exist.
  if (!something_waits_) set_aside_.forget_due(clock_.now());
  drained_ = after.acknowledged_through == after.last_downlink_id && after.late.empty() && set_aside_.empty();
  return {};
}

Status Downlink::send_in_contact(State& after, bool& sent) {
  const State before = after;
  const Status status = send_next(after, sent);
  if (status.is(StatusCode::transfer_queue_full)) {
    after = before;
    sent = changed_ = false;
    event_ = {};
    return {};
  }
  // The store answers not_found for missing records: only a link is not ready.
  if (status.is(StatusCode::not_ready)) {
    after = before;
    sent = changed_ = false;
    event_ = {};
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

Status Downlink::set_aside(const Status& fault, bool& others) {
  others = false;
  if (subject_.kind == FileClass::count || store_failed_ || fault.is(StatusCode::assertion_failed)) return fault;
  const bool of_link = file_.link_failed();
  if (!of_link && is_transient(fault)) {
    // A fault of the whole store is no statement about this file.
    CameraRecord any;
    const Status answer = last(store_, any);
    if (is_transient(answer)) return fault;
  }
  std::uint32_t faults = 0;
  const std::uint32_t most = is_transient(fault) ? most_passing_faults : most_lasting_faults;
  const auto kind = static_cast<std::uint8_t>(subject_.kind);
  if (!set_aside_.add(kind, subject_.id, clock_.now(), !of_link, most, faults)) return fault;
  others = true;
  if (faults > 1) return {};
  return {StatusCode::file_set_aside, subject_.id, static_cast<std::int64_t>(fault.code)};
}

Status Downlink::hear_layers(const DownlinkRecord& record, ProductRecord product) {
  for (unsigned layer = record.first_layer; layer >= 1 && layer <= record.last_layer; ++layer) {
    product.layers_held = static_cast<std::uint8_t>(product.layers_held | (1U << (layer - 1)));
  }
  if (product.layers_sent >= layers_of(product) && all_held(product)) product.state = ProductState::acknowledged;
  return amend(store_, product);
}

Status Downlink::hear_one(DownlinkRecord record, State& after, bool& settled, bool& heard) {
  ProductRecord product;
  bool known = false;
  if (record.kind == DownlinkKind::product) {
    const Status found = get(store_, record.subject_id, product);
    // The link may report it only once: it is queried when the product can be updated.
    if (is_transient(found)) return {};
    known = found.ok();
  }
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;
  const Status answer = link_.acknowledged(record.name, bytes, crc);
  // A damaged copy on the ground is no confirmation; the file stays on board.
  if (!answer.ok() || bytes != record.bytes || crc != record.crc32) return drop_if_lost(record, after, settled, heard);
  record.acknowledged_ns = clock_.now();
  heard = settled = true;
  ILP_TRY(put(store_, record));
  return known ? hear_layers(record, product) : Status{};
}

Status Downlink::drop_if_lost(const DownlinkRecord& record, State& after, bool& settled, bool& heard) {
  if (record.kind == DownlinkKind::product || mission_.confirmation_timeout_s <= 0) return {};
  const double waited_s = 1e-9 * static_cast<double>(newest_sent_ns_ - record.sent_ns);
  if (waited_s <= mission_.confirmation_timeout_s) return {};
  Late late{FileClass::records, record.subject_id};
  if (record.kind == DownlinkKind::points) late.kind = FileClass::points;
  if (record.subject_id < 0) late = {FileClass::events, -record.subject_id};
  bool again = record.subject_id == 0;
  for (const Late& one : after.late) again = again || one == late;
  if (!again && !after.late.push_back(late)) return {};
  ILP_TRY(erase<DownlinkRecord>(store_, record.id));
  heard = settled = true;
  event_ = {StatusCode::file_lost, late.id, static_cast<std::int64_t>(late.kind)};
  return {};
}

Status Downlink::hear(State& after, bool& heard) {
  heard = false;
  DownlinkRecord record;
  // A missing confirmation must not delay later ones, so all unconfirmed files take turns.
  if (asked_through_ < after.acknowledged_through) asked_through_ = after.acknowledged_through;
  std::int64_t id = asked_through_;
  bool all_before = id == after.acknowledged_through;
  bool ended = false;
  for (int asked = 0; asked < acknowledgements_per_step && !(heard && hear_alone_ > 0); ++asked) {
    Found found{};
    ILP_TRY(find_next(store_, id, record, found));
    ended = found == Found::nothing;
    if (ended) break;
    id = record.id;
    bool settled = true;
    if (found == Found::damaged) {
      heard = true;
      after.check_products_from = 1;
      ILP_TRY(erase<DownlinkRecord>(store_, id));
    } else {
      settled = record.acknowledged_ns != 0;
      // If this one fails, the earlier ones are committed without it.
      asked_through_ = id;
      if (!settled) ILP_TRY(hear_one(record, after, settled, heard));
    }
    all_before = all_before && settled;
    if (all_before) after.acknowledged_through = id;
  }
  if (heard && hear_alone_ > 0) --hear_alone_;
  asked_through_ = ended ? after.acknowledged_through : id;
  return {};
}

Status Downlink::check_products(State& after, bool& changed) {
  constexpr int products_per_step = 8;
  changed = after.check_products_from > 0;
  for (int i = 0; i < products_per_step && after.check_products_from > 0; ++i) {
    ProductRecord product;
    Found found{};
    ILP_TRY(find_next(store_, after.check_products_from - 1, product, found));
    after.check_products_from = found == Found::nothing ? 0 : product.id + 1;
    if (found != Found::sound) continue;
    const bool open = product.state == ProductState::stored || product.state == ProductState::sent;
    int held = 0;
    while (held < product.layers_sent && (product.layers_held & (1U << static_cast<unsigned>(held))) != 0) ++held;
    if (!open || product.data.bytes == 0 || held == product.layers_sent) continue;
    product.layers_sent = static_cast<std::uint8_t>(held);
    product.state = ProductState::stored;
    ILP_TRY(amend(store_, product));
  }
  return {};
}

Status Downlink::hear_all() {
  State after = state_;
  if (after.acknowledged_through == after.last_downlink_id) return {};
  bool heard = false;
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  Status status = hear(after, heard);
  if (status.ok() && heard) status = transaction.commit(cursor_, after, cursor_);
  if (status.ok()) state_ = after;
  if (!status.ok()) hear_alone_ = heard_alone;
  return status;
}

StepResult Downlink::step() {
  event_ = {};
  subject_ = {};
  store_failed_ = changed_ = false;
  // Confirmations are on disk before anything is sent, and stay if sending fails.
  const Status unheard = hear_all();
  const Status told = unheard.ok() ? event_ : Status{};
  event_ = {};
  StepResult result = send_one();
  if (result.status.ok()) result.status = unheard.ok() ? told : unheard;
  return result;
}

StepResult Downlink::send_one() {
  State after = state_;
  const Contact contact = contact_at(mission_, clock_.now());
  bool sent = false;
  bool begun = false;
  bool checked = false;
  StepTransaction transaction(store_, checkpoint);
  Status status = transaction.begin();
  if (status.ok()) status = begin_pass(after, contact, begun);
  if (status.ok()) status = check_products(after, checked);
  if (!status.ok()) return {status, false};
  credit(after, contact);
  status = send_in_contact(after, sent);
  if (!status.ok()) {
    bool others = false;
    status = set_aside(status, others);
    return {status, others};
  }
  if (sent || begun || checked || changed_) {
    status = transaction.commit(cursor_, after, cursor_);
    if (!status.ok()) return {status, false};
  }
  state_ = after;
  return {event_, sent || changed_};
}

}  // namespace ilp
