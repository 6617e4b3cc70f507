// Follows requests whose completion takes time, in the records of the components that carry them out.
#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/new_command.hpp"

namespace ilp {
namespace {

constexpr int captures_per_step = 64;
constexpr int events_per_step = 256;
// Captures of a series are commanded this long before their time: the capture clock holds a limited number.
constexpr TimeNs series_lead_ns = 2 * ns_per_s;
constexpr TimeNs report_patience_ns = 10 * ns_per_s;

/// One look at the open requests.
struct Look {
  const CommandingWiring& wiring;
  CommandingState& after;
  RequestUpdateList& updates;
  TimeNs now;
  bool changed;
};

/// Of a commanded place; 0 where the record states none.
std::int64_t nearest_approach_m(const CaptureRecord& capture) {
  constexpr double most_m = 1e9;
  return capture.distance_m >= 0 && capture.distance_m < most_m ? static_cast<std::int64_t>(capture.distance_m) : 0;
}

Status fault_of(const CaptureRecord& capture, const MissionParameters& mission) {
  switch (capture.state) {
    case CaptureState::no_frame:
      if (capture.reason == 0)
        return {StatusCode::capture_missed, capture.id, ns_from_seconds(mission.capture_timeout_s) / ns_per_ms};
      return {static_cast<StatusCode>(capture.reason), capture.id,
              distance(capture.exposed_ns, capture.requested_ns) / ns_per_us};
    case CaptureState::rejected:
      return {static_cast<StatusCode>(capture.reason), capture.command_id, nearest_approach_m(capture)};
    case CaptureState::superseded:
      return {StatusCode::capture_superseded, capture.id};
    case CaptureState::pending:
    case CaptureState::exposed:
    case CaptureState::count:
      break;
  }
  return {};
}

/// The second cursor of the overlap checker and of telemetry is the last command that they have obeyed.
Result<bool> obeyed(Reader<CheckpointRecord> store, std::int64_t command_id,
                    ComponentId component = ComponentId::overlap_checker) {
  Cursor cursor;
  ILP_TRY(saved_cursor(store, component, cursor));
  return cursor.second >= command_id;
}

Status follow_captures(Look& look) {
  auto& [wiring, after, updates, now, changed] = look;
  std::size_t kept = 0;
  for (const WatchedCapture watched : after.watched) {
    CaptureRecord capture;
    ILP_TAKE(const bool found, find(wiring.store, watched.capture_id, capture));
    if (found && capture.state == CaptureState::pending) {
      after.watched[kept++] = watched;
      continue;
    }
    changed = true;
    const Status fault = found ? fault_of(capture, wiring.mission) : Status{StatusCode::no_completion, 0};
    for (OpenRequest& request : after.open) {
      if (request.id != watched.request_id) continue;
      if (request.outstanding > 0) --request.outstanding;
      ++request.settled;
      if (!fault.ok() && request.fault == 0) {
        request.fault = static_cast<std::uint16_t>(fault.code);
        request.fault_a = fault.a;
        request.fault_b = fault.b;
      }
      if (fault.ok() && request.interval_ns != 0)
        static_cast<void>(updates.push_back({request, {}, RequestUpdate::Kind::progress}));
    }
  }
  while (after.watched.size() > kept) after.watched.pop_back();
  return {};
}

Status command_series(Look& look) {
  auto& [wiring, after, updates, now, changed] = look;
  for (OpenRequest& request : after.open) {
    // Bounded by the captures that can be watched.
    while (request.kind == OpenKind::captures && request.left > 0 && request.next_ns - now < series_lead_ns &&
           request.outstanding + after.watched.size() < after.watched.capacity()) {
      CommandRecord command{.kind = CommandKind::capture, .at_ns = request.next_ns, .request_id = request.id};
      ILP_TRY(write_command(wiring, command));
      request.subject_id = command.id;
      request.next_ns += request.interval_ns;
      --request.left;
      ++request.outstanding;
      changed = true;
    }
  }
  return {};
}

Result<bool> is_flushed(Reader<StripRecord, PoseRecord> store) {
  StripRecord strip;
  Status status = last(store, strip);
  if (status.ok() && strip.end == StripEnd::open) status = get(store, strip.id - 1, strip);
  if (status.is(StatusCode::not_found)) return true;
  PoseRecord pose;
  // The overlap checker writes a damaged strip again.
  ILP_TAKE(const bool any, read_by(status));
  if (!any) return false;
  ILP_TAKE(const bool known, find(store, strip.last_keyframe_id, pose));
  return known && !is_open(pose.state);
}

Result<bool> is_restarted(Reader<EventRecord> store, OpenRequest& request) {
  // The mark moves on, so that each event is examined once, however many there are.
  for (int i = 0; i < events_per_step; ++i) {
    EventRecord event;
    ILP_TAKE(const Found found, find_next(store, request.mark_id, event));
    if (found == Found::nothing) return false;
    request.mark_id = event.id;
    if (event.code == static_cast<std::uint16_t>(StatusCode::component_restarted) && event.a == request.subject_id)
      return true;
  }
  return false;
}

Result<bool> is_done(const CommandingWiring& wiring, OpenRequest& request) {
  switch (request.kind) {
    case OpenKind::captures:
      return request.left == 0 && request.outstanding == 0;
    case OpenKind::end_strip:
      return obeyed(wiring.store, request.subject_id);
    case OpenKind::flush: {
      ILP_TAKE(const bool ended, obeyed(wiring.store, request.subject_id));
      return ended ? is_flushed(wiring.store) : false;
    }
    case OpenKind::begin_strip: {
      ILP_TAKE(const bool ended, obeyed(wiring.store, request.subject_id));
      StripRecord strip;
      ILP_TAKE(const bool found, read_by(last(wiring.store, strip)));
      // A strip that is open now has begun after the command.
      return ended && found && strip.end == StripEnd::open;
    }
    case OpenKind::delete_product: {
      ProductRecord product;
      const Status status = get(wiring.store, request.subject_id, product);
      ILP_TAKE(const bool found, read_by(status));
      return status.is(StatusCode::not_found) || (found && product.state == ProductState::dropped);
    }
    case OpenKind::restart:
      return is_restarted(wiring.store, request);
    case OpenKind::report:
      return obeyed(wiring.store, request.subject_id, ComponentId::telemetry);
    case OpenKind::noted:
      return true;
  }
  return false;
}

/// Whether the request is over.
Result<bool> follow_one(OpenRequest& request, Look& look) {
  auto& [wiring, after, updates, now, changed] = look;
  if (request.begin_ns > now || updates.size() + 2 > updates.capacity()) return false;
  if (request.begin_ns != 0) {
    request.begin_ns = 0;
    changed = true;
    static_cast<void>(updates.push_back({request, {}, RequestUpdate::Kind::begun}));
  }
  const std::int64_t mark_id = request.mark_id;
  ILP_TAKE(const bool done, is_done(wiring, request));
  changed = changed || request.mark_id - mark_id >= events_per_step;
  if (!done && now <= request.deadline_ns) return false;
  Status status{static_cast<StatusCode>(request.fault), request.fault_a, request.fault_b};
  if (!done) status = {StatusCode::no_completion, (now - request.deadline_ns) / ns_per_s};
  static_cast<void>(updates.push_back({request, status}));
  ++(status.ok() ? after.counts.completed : after.counts.failed);
  changed = true;
  return true;
}

}  // namespace

Status write_command(const CommandingWiring& wiring, CommandRecord& command) {
  command.time_ns = wiring.clock.now();
  return put_new_command(wiring.store, command);
}

Status keep_open(OpenRequest request, ServiceCall& call) {
  request.packet = call.answer.request().packet;
  request.source = call.answer.request().source;
  request.ack_flags = call.answer.ack_flags();
  if (call.answer.postponed()) request.begin_ns = call.change.nominal_ns;
  auto& open = call.change.after.open;
  if (!open.push_back(request)) return {StatusCode::requests_full, static_cast<std::int64_t>(open.size())};
  call.answer.start();
  call.answer.keep_open();
  return {};
}

Status wait_for_telemetry(std::int64_t command_id, ServiceCall& call) {
  return keep_open({.id = call.change.after.last_request_id,
                    .deadline_ns = call.now() + report_patience_ns,
                    .subject_id = command_id,
                    .kind = OpenKind::report},
                   call);
}

Result<bool> learn_captures(const CommandingWiring& wiring, CommandingState& after) {
  bool any = false;
  for (int i = 0; i < captures_per_step && !after.watched.full(); ++i) {
    CaptureRecord capture;
    ILP_TAKE(const Found next, find_next(wiring.store, after.last_capture_id, capture));
    if (next == Found::nothing) break;
    after.last_capture_id = capture.id;
    if (next == Found::damaged || capture.command_id == 0) continue;
    CommandRecord command;
    ILP_TAKE(const bool known, find(wiring.store, capture.command_id, command));
    if (!known || command.request_id == 0) continue;
    for (const OpenRequest& request : after.open) {
      if (request.id == command.request_id) any = after.watched.push_back({capture.id, request.id}) || any;
    }
  }
  return any;
}

Result<bool> follow_requests(const CommandingWiring& wiring, CommandingState& after, RequestUpdateList& updates) {
  ILP_TAKE(const bool learned, learn_captures(wiring, after));
  Look look{wiring, after, updates, wiring.clock.now(), learned};
  ILP_TRY(follow_captures(look));
  ILP_TRY(command_series(look));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < after.open.size(); ++i) {
    OpenRequest request = after.open[i];
    ILP_TAKE(const bool over, follow_one(request, look));
    if (!over) after.open[kept++] = request;
  }
  while (after.open.size() > kept) after.open.pop_back();
  return look.changed;
}

void report_update(const RequestUpdate& updates, TelemetryWriter& writer) {
  Answer answer(writer, {updates.request.packet, updates.request.source}, updates.request.ack_flags);
  if (updates.kind == RequestUpdate::Kind::begun) {
    answer.start();
    return;
  }
  answer.continue_started();
  if (updates.kind == RequestUpdate::Kind::progress) {
    answer.progress(updates.request.settled % 256U);
  } else {
    answer.finish(updates.status);
  }
}

}  // namespace ilp
