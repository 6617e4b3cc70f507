#include "fsw/downlink/downlink_choice.hpp"

#include "fsw/downlink/downlink.hpp"
#include "fsw/shared/product_layers.hpp"

namespace ilp {
namespace {

/// The next file is chosen when the link has less than this left to send. That is longer than the time between two
/// steps, so that the link does not run dry.
constexpr double lead_s = 1;
constexpr TimeNs events_period_ns = 120 * ns_per_s;
/// Part of a pass for products that have waited too long. The rest is used by worth.
constexpr std::int64_t overdue_part = 4;
/// Head of the longer file and of the refinement itself, as far as it is known without the product's bytes.
constexpr std::uint32_t refinement_overhead_bytes = 320;
constexpr std::int64_t usual_records_bytes = 3000;
constexpr std::int64_t usual_events_bytes = 8000;

bool can_go(const ProductRecord& product) {
  return product.state == ProductState::stored && product.data.bytes != 0 &&
         product.data.bytes <= limits::max_product_bytes && product.layers_sent < layers_of(product);
}

PlanCandidate candidate_of(const ProductRecord& product, const ProductUtility& utility) {
  PlanCandidate candidate;
  candidate.id = product.id;
  candidate.sent = product.layers_sent;
  candidate.layers = static_cast<std::uint8_t>(layers_of(product));
  candidate.requested = utility.requested;
  double before = 0;
  for (int layers = 1; layers <= candidate.layers; ++layers) {
    const auto place = static_cast<std::size_t>(layers - 1);
    std::uint32_t bytes = bytes_to(product, layers);
    if (candidate.sent > 0) {
      const std::uint32_t down = bytes_to(product, candidate.sent);
      bytes = layers > candidate.sent ? bytes - down + refinement_overhead_bytes : 0;
    }
    candidate.bytes[place] = bytes;
    const double own = utility_of_layers(product, utility, layers);
    // More layers are never worth less, whatever a measured quality says.
    candidate.utility[place] = own > before ? own : before;
    before = candidate.utility[place];
  }
  return candidate;
}

}  // namespace

const LateFile* DownlinkChoice::late_one(const State& after, FileClass kind) const {
  for (const LateFile& late : after.late) {
    if (late.kind == kind && !rests(kind, late.id)) return &late;
  }
  return nullptr;
}

Status DownlinkChoice::find_requests() {
  workspace_.requests.clear();
  CommandRecord command;
  for (;;) {  // bound: limits::max_commands
    ILP_TAKE(const Found found, find_next(wiring_.store, command.id, command));
    if (found == Found::nothing) return {};
    const bool refine = found == Found::valid && command.kind == CommandKind::refine;
    if (!refine || requested(command.keyframe_id)) continue;
    if (workspace_.requests.push_back(command.keyframe_id)) continue;
    workspace_.requests.erase(0);
    static_cast<void>(workspace_.requests.push_back(command.keyframe_id));
  }
}

bool DownlinkChoice::requested(std::int64_t keyframe_id) const {
  for (const std::int64_t id : workspace_.requests) {
    if (id == keyframe_id) return true;
  }
  return false;
}

bool DownlinkChoice::waits(const State& after, const ProductRecord& product) const {
  if (!can_go(product) || rests(FileClass::products, product.id)) return false;
  for (const LateFile& late : after.late) {
    if (late.kind == FileClass::records && late.id == product.keyframe_id) return false;
  }
  return true;
}

Result<bool> DownlinkChoice::next_waiting(const State& after, ProductRecord& product) {
  for (;;) {  // bound: the products in the store; each turn reads a later one
    ILP_TAKE(const Found found, find_next(wiring_.store, product.id, product));
    if (found == Found::nothing) return false;
    if (found == Found::damaged) continue;
    // The records of a keyframe are sent after its image is made.
    if (product.keyframe_id > after.records_through) return false;
    if (waits(after, product)) return true;
  }
}

Status DownlinkChoice::gather(const State& after) {
  ILP_TRY(find_requests());
  workspace_.candidates.clear();
  ProductRecord product;
  RichnessRecord richness;
  for (;;) {  // bound: the products in the store; each turn reads a later one
    ILP_TAKE(const bool any, next_waiting(after, product));
    if (!any) return {};
    if (richness.id != product.keyframe_id) {
      ILP_TAKE(const bool rated, find(wiring_.store, product.keyframe_id, richness));
      // Unreadable richness has no weight: the product's own priority counts.
      if (!rated) richness = {};
    }
    constexpr double usual_pixels = 640.0 * 480.0;
    ProductUtility utility;
    // The plan's priority contains more than the index alone: a depth map goes before its image.
    utility.richness = product.priority;
    utility.newly_seen_share = richness.mask_fraction;
    utility.newly_seen_px = richness.mask_fraction * usual_pixels;
    utility.requested = requested(product.keyframe_id);
    workspace_.candidates.offer(candidate_of(product, utility));
  }
}

Result<bool> DownlinkChoice::send_planned(std::int64_t most, State& after) {
  ILP_TRY(gather(after));
  const std::span<const PlanCandidate> candidates = workspace_.candidates.all();
  plan_pass(candidates, work_.free_bytes > 0 ? static_cast<std::uint64_t>(work_.free_bytes) : 0, workspace_.planning,
            workspace_.plan);
  work_.something_waits = work_.something_waits || !candidates.empty();
  PlannedFile file;
  if (!workspace_.plan.files.empty()) {
    file = workspace_.plan.files[0];
  } else {
    // Nothing fits. At the beginning of a pass, a file that is larger than the pass is sent.
    double best = 0;
    for (const PlanCandidate& candidate : candidates) {
      const double efficiency = best_efficiency(candidate);
      const std::uint32_t bytes = candidate.bytes[candidate.sent];
      if ((file.id != 0 && efficiency <= best) || !fits(after, bytes)) continue;
      best = efficiency;
      file = {candidate.id, 0, static_cast<std::uint8_t>(candidate.sent + 1), bytes};
    }
  }
  if (file.id == 0) return false;
  if (file.bytes > most) {
    after.planned_bytes = file.bytes;
    return false;
  }
  ProductRecord product;
  ILP_TRY(get(wiring_.store, file.id, product));
  return files_.send_layers(product, file.last_layer, after);
}

Result<bool> DownlinkChoice::send_overdue(State& after) {
  const std::size_t passes = wiring_.mission.overdue_passes;
  const std::int64_t newest =
      after.product_at_pass[passes < limits::max_overdue_passes ? passes : limits::max_overdue_passes];
  ProductRecord product;
  while (product.id < newest) {  // bound: the products up to `newest`; each turn reads a later one
    ILP_TAKE(const Found found, find_next(wiring_.store, product.id, product));
    if (found == Found::nothing) return false;
    if (found == Found::damaged || product.id > newest || !waits(after, product) || product.layers_sent != 0) continue;
    const std::int64_t pass_bytes = after.pass_bytes + (work_.free_bytes > 0 ? work_.free_bytes : 0);
    const std::int64_t bytes = bytes_to(product, 1);
    const bool first = after.overdue_bytes == 0;
    if (!first && (after.overdue_bytes + bytes) * overdue_part > pass_bytes) return false;
    if (!fits(after, bytes)) return false;
    const std::int64_t before = after.pass_bytes;
    // Records are sent in order, and those of an older keyframe have waited as long.
    const bool known = product.keyframe_id <= after.records_through;
    ILP_TAKE(const bool sent, known ? files_.send_layers(product, 1, after) : send_next_records(no_limit_bytes, after));
    after.overdue_bytes += after.pass_bytes - before;
    return sent;
  }
  return false;
}

Result<bool> DownlinkChoice::send_in_order(std::int64_t most, State& after) {
  ProductRecord product;
  ILP_TAKE(const bool any, next_waiting(after, product));
  if (!any) return false;
  const int layers = layers_of(product);
  const std::int64_t bytes = bytes_to(product, layers);
  if (!may_go(after, bytes, most)) {
    if (bytes > most) after.planned_bytes = bytes;
    return false;
  }
  return files_.send_layers(product, layers, after);
}

Result<bool> DownlinkChoice::send_next_records(std::int64_t most, State& after) {
  const LateFile* const late = late_one(after, FileClass::records);
  if (late != nullptr && !may_go(after, usual_records_bytes, most)) return false;
  if (late != nullptr) return files_.send_records(late->id, after);
  // Each turn makes one more of them late.
  for (std::size_t turn = 0; turn <= max_late_files; ++turn) {
    KeyframeRecord keyframe;
    ILP_TAKE(const Found found, find_next(wiring_.store, after.records_through, keyframe));
    if (found == Found::nothing) return false;
    // The compressor works in order: an image of this or a later keyframe means that this one is done.
    ProductRecord product;
    ILP_TAKE(const Found made, find_next(wiring_.store, product_id(keyframe.id, ProductKind::image) - 1, product));
    if (made == Found::nothing) return false;
    if (wiring_.mission.use_map) {
      FixRecord fix;
      ILP_TAKE(const Found fixed, find_next(wiring_.store, keyframe.id - 1, fix));
      if (fixed == Found::nothing) return false;
    }
    if (!rests(FileClass::records, keyframe.id)) {
      if (!may_go(after, usual_records_bytes, most)) return false;
      return files_.send_records(keyframe.id, after);
    }
    // It is quarantined, and the files after it are sent.
    if (!after.late.push_back({FileClass::records, keyframe.id})) return false;
    after.records_through = keyframe.id;
  }
  return false;
}

Result<bool> DownlinkChoice::send_next_points(std::int64_t most, State& after) {
  const LateFile* const late = late_one(after, FileClass::points);
  if (late != nullptr) return files_.send_points(late->id, most, after);
  for (;;) {  // bound: the keyframes up to `records_through`
    StructureRecord structure;
    ILP_TAKE(const Found found, find_next(wiring_.store, after.points_through, structure));
    if (found == Found::nothing) return false;
    if (structure.id > after.records_through) return false;
    if (rests(FileClass::points, structure.id)) {
      if (!after.late.push_back({FileClass::points, structure.id})) return false;
    } else if (found == Found::damaged || structure.points.bytes != 0) {
      return files_.send_points(structure.id, most, after);
    }
    after.points_through = structure.id;
  }
}

Result<bool> DownlinkChoice::send_events_if_due(std::int64_t most, State& after) {
  const LateFile* const late = late_one(after, FileClass::events);
  if (late != nullptr) {
    if (!may_go(after, usual_events_bytes, most)) return false;
    EventRecord event;
    const Status any = next(wiring_.store, late->id - 1, event);
    const bool gone = any.is(StatusCode::not_found) || (any.ok() && event.id >= late->id + events_per_file);
    if (!gone) return files_.send_events(late->id - 1, true, files_.housekeeping_fingerprint(), after);
    files_.drop_late(LateFile(*late), after);
  }
  EventRecord newest;
  const Status any = last(wiring_.store, newest);
  if (any.is(StatusCode::record_damaged)) newest.id = any.a;
  if (is_transient(any)) return any;
  const bool new_events = newest.id > after.events_through;
  const std::int64_t housekeeping_steps = files_.housekeeping_fingerprint();
  const bool enough = new_events && newest.id - after.events_through >= events_per_file;
  const bool old = new_events && wiring_.clock.now() - after.events_sent_ns >= events_period_ns;
  if (!enough && !old && housekeeping_steps == after.housekeeping_steps) return false;
  if (!may_go(after, usual_events_bytes, most)) return false;
  // Events of a file that was quarantined wait. Only later ones follow them.
  if (rests(FileClass::events, after.events_through + 1)) return false;
  return files_.send_events(after.events_through, false, housekeeping_steps, after);
}

Result<bool> DownlinkChoice::send_class(FileClass kind, std::int64_t most, State& after) {
  switch (kind) {
    case FileClass::products:
      return wiring_.mission.downlink_order == DownlinkOrder::origin ? send_in_order(most, after)
                                                                     : send_planned(most, after);
    case FileClass::records:
      return send_next_records(most, after);
    case FileClass::points:
      return send_next_points(most, after);
    default:
      return send_events_if_due(most, after);
  }
}

Result<bool> DownlinkChoice::send_owed(State& after) {
  // With less credit the next file of the class does not fit, by the sizes known so far.
  const std::int64_t least[file_classes] = {after.planned_bytes, usual_records_bytes, 1, usual_events_bytes};
  bool tried[file_classes] = {};
  for (std::size_t turn = 0; turn < file_classes; ++turn) {
    std::size_t best = file_classes;
    for (std::size_t i = 0; i < file_classes; ++i) {
      if (tried[i] || after.owed_bytes[i] == 0 || after.owed_bytes[i] < least[i]) continue;
      if (best == file_classes || after.owed_bytes[i] > after.owed_bytes[best]) best = i;
    }
    if (best == file_classes) return false;
    tried[best] = true;
    work_.something_waits = false;
    ILP_TAKE(const bool sent, send_class(static_cast<FileClass>(best), after.owed_bytes[best], after));
    if (sent) return true;
    // No file waits, so there is nothing to save credit for.
    if (!work_.something_waits) after.owed_bytes[best] = 0;
  }
  return false;
}

Result<bool> DownlinkChoice::send_next(State& after) {
  work_.drained = false;
  const Contact contact = contact_at(wiring_.mission, wiring_.clock.now());
  if (!contact.open || after.credit_bytes < 0 || wiring_.mission.link_bytes_per_s <= 0) return false;
  std::int64_t unsent = 0;
  ILP_TRY(wiring_.link.unsent(unsent));
  if (static_cast<double>(unsent) >= lead_s * wiring_.mission.link_bytes_per_s) {
    // The link needs its time for what it has: headers, telemetry and what was lost. None of it is saved up.
    if (after.credit_bytes > 0) after.credit_bytes = 0;
    return false;
  }
  work_.free_bytes -= unsent;
  constexpr FileClass by_utility[] = {FileClass::records, FileClass::products, FileClass::points, FileClass::events};
  constexpr FileClass by_origin[] = {FileClass::products, FileClass::records, FileClass::points, FileClass::events};
  const bool in_order = wiring_.mission.downlink_order == DownlinkOrder::origin;
  if (!in_order) {
    ILP_TAKE(const bool sent, send_overdue(after));
    if (sent) return true;
  }
  ILP_TAKE(const bool owed, send_owed(after));
  if (owed) return true;
  work_.something_waits = false;
  for (const FileClass kind : in_order ? by_origin : by_utility) {
    ILP_TAKE(const bool sent, send_class(kind, no_limit_bytes, after));
    if (sent) return true;
  }
  // Entries that were due and did not appear no longer exist.
  if (!work_.something_waits) work_.quarantine.forget_due(wiring_.clock.now());
  work_.drained =
      after.acknowledged_through == after.last_downlink_id && after.late.empty() && work_.quarantine.empty();
  return false;
}

}  // namespace ilp
