// Requests whose completion takes time. It is found in the records of the components that carry them out.
#include "fsw/commanding/telecommander.hpp"

namespace ilp {
namespace {

constexpr int captures_per_step = 64;
constexpr int events_per_step = 256;
// Captures of a series are commanded this long before their time: the capture clock holds a limited number.
constexpr TimeNs series_lead_ns = 2 * ns_per_s;

Status fault_of(const CaptureRecord& capture, const MissionParameters& mission) {
  switch (capture.state) {
    case CaptureState::no_frame:
      if (capture.reason == 0)
        return {StatusCode::capture_missed, capture.id, ns_from_seconds(mission.capture_timeout_s) / ns_per_ms};
      return {static_cast<StatusCode>(capture.reason), capture.id,
              distance(capture.exposed_ns, capture.requested_ns) / ns_per_us};
    case CaptureState::rejected:
      return {static_cast<StatusCode>(capture.reason), capture.command_id};
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
Status obeyed(Reader<CheckpointRecord> store, std::int64_t command_id, bool& done,
              ComponentId component = ComponentId::overlap_checker) {
  Cursor cursor;
  ILP_TRY(saved_cursor(store, component, cursor));
  done = cursor.second >= command_id;
  return {};
}

}  // namespace

Status Telecommander::follow_requests() {
  bool changed = false;
  if (state_.open.empty()) {
    // No request waits; the place among the captures is kept with the next telecommand.
    return learn_captures(state_, changed);
  }
  workspace_.news.clear();
  workspace_.change.after = state_;
  State& after = workspace_.change.after;
  const TimeNs now = wiring_.clock.now();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(learn_captures(after, changed));
  ILP_TRY(follow_captures(after, workspace_.news, changed));
  ILP_TRY(command_series(after, now, changed));
  ILP_TRY(follow_open(after, now, workspace_.news, changed));
  if (!changed) return {};
  ILP_TRY(transaction.commit(cursor_, after, cursor_, state_));
  workspace_.counts_changed = true;
  for (const News& item : workspace_.news) report_news(item);
  return {};
}

Status Telecommander::learn_captures(State& after, bool& changed) {
  for (int i = 0; i < captures_per_step && !after.watched.full(); ++i) {
    CaptureRecord capture;
    ILP_TAKE(const Found found, find_next(wiring_.store, after.last_capture_id, capture));
    if (found == Found::nothing) return {};
    after.last_capture_id = capture.id;
    if (found == Found::damaged || capture.command_id == 0) continue;
    CommandRecord command;
    const Status known = get(wiring_.store, capture.command_id, command);
    if (!known.ok() && !is_gone(known)) return known;
    if (!known.ok() || command.request_id == 0) continue;
    for (const OpenRequest& request : after.open) {
      if (request.id != command.request_id) continue;
      static_cast<void>(after.watched.push_back({capture.id, request.id}));
      changed = true;
    }
  }
  return {};
}

Status Telecommander::follow_captures(State& after, NewsList& news, bool& changed) {
  std::size_t kept = 0;
  for (const Watched watched : after.watched) {
    CaptureRecord capture;
    const Status found = get(wiring_.store, watched.capture_id, capture);
    if (!found.ok() && !is_gone(found)) return found;
    if (found.ok() && capture.state == CaptureState::pending) {
      after.watched[kept++] = watched;
      continue;
    }
    changed = true;
    const Status fault = found.ok() ? fault_of(capture, wiring_.mission) : Status{StatusCode::no_completion, 0};
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
        static_cast<void>(news.push_back({request, {}, News::Kind::progress}));
    }
  }
  while (after.watched.size() > kept) after.watched.pop_back();
  return {};
}

Status Telecommander::command_series(State& after, TimeNs now, bool& changed) {
  for (OpenRequest& request : after.open) {
    // Bounded by the captures that can be watched.
    while (request.kind == OpenKind::captures && request.left > 0 && request.next_ns - now < series_lead_ns &&
           request.outstanding + after.watched.size() < after.watched.capacity()) {
      CommandRecord command;
      command.kind = CommandKind::capture;
      command.at_ns = request.next_ns;
      command.request_id = request.id;
      ILP_TRY(write_command(command, request.subject_id));
      request.next_ns += request.interval_ns;
      --request.left;
      ++request.outstanding;
      changed = true;
    }
  }
  return {};
}

Status Telecommander::follow_one(OpenRequest& request, TimeNs now, NewsList& news, bool& over, bool& changed) {
  over = false;
  if (request.begin_ns > now || news.size() + 2 > news.capacity()) return {};
  if (request.begin_ns != 0) {
    request.begin_ns = 0;
    changed = true;
    static_cast<void>(news.push_back({request, {}, News::Kind::begun}));
  }
  const std::int64_t mark_id = request.mark_id;
  ILP_TRY(is_done(request, over));
  changed = changed || request.mark_id - mark_id >= events_per_step;
  Status status{static_cast<StatusCode>(request.fault), request.fault_a, request.fault_b};
  if (!over && now > request.deadline_ns) {
    over = true;
    status = {StatusCode::no_completion, (now - request.deadline_ns) / ns_per_s};
  }
  if (over) static_cast<void>(news.push_back({request, status, News::Kind::finished}));
  return {};
}

Status Telecommander::follow_open(State& after, TimeNs now, NewsList& news, bool& changed) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < after.open.size(); ++i) {
    OpenRequest request = after.open[i];
    bool over = false;
    ILP_TRY(follow_one(request, now, news, over, changed));
    if (!over) {
      after.open[kept++] = request;
      continue;
    }
    changed = true;
    if (news.back().status.ok()) {
      ++after.counts.completed;
    } else {
      ++after.counts.failed;
    }
  }
  while (after.open.size() > kept) after.open.pop_back();
  return {};
}

Status Telecommander::is_done(OpenRequest& request, bool& done) {
  done = false;
  switch (request.kind) {
    case OpenKind::captures:
      done = request.left == 0 && request.outstanding == 0;
      return {};
    case OpenKind::end_strip:
      return obeyed(wiring_.store, request.subject_id, done);
    case OpenKind::flush:
      ILP_TRY(obeyed(wiring_.store, request.subject_id, done));
      return done ? is_flushed(done) : Status{};
    case OpenKind::begin_strip: {
      ILP_TRY(obeyed(wiring_.store, request.subject_id, done));
      StripRecord strip;
      const Status found = last(wiring_.store, strip);
      if (!found.ok() && !is_gone(found)) return found;
      // A strip that is open now has begun after the command.
      done = done && found.ok() && strip.end == StripEnd::open;
      return {};
    }
    case OpenKind::delete_product: {
      ProductRecord product;
      const Status found = get(wiring_.store, request.subject_id, product);
      if (!found.ok() && !is_gone(found)) return found;
      done = found.is(StatusCode::not_found) || (found.ok() && product.state == ProductState::dropped);
      return {};
    }
    case OpenKind::restart:
      return is_restarted(request, done);
    case OpenKind::report:
      return obeyed(wiring_.store, request.subject_id, done, ComponentId::telemetry);
    case OpenKind::noted:
      done = true;
      return {};
  }
  return {};
}

Status Telecommander::is_flushed(bool& done) {
  StripRecord strip;
  Status found = last(wiring_.store, strip);
  if (found.ok() && strip.end == StripEnd::open) found = get(wiring_.store, strip.id - 1, strip);
  done = found.is(StatusCode::not_found);
  // The overlap checker writes a damaged strip again.
  if (is_gone(found)) return {};
  ILP_TRY(found);
  PoseRecord pose;
  found = get(wiring_.store, strip.last_keyframe_id, pose);
  if (!found.ok() && !is_gone(found)) return found;
  done = found.ok() && pose.state != PoseState::provisional;
  return {};
}

Status Telecommander::is_restarted(OpenRequest& request, bool& done) {
  // The mark moves on, so that each event is examined once, however many there are.
  for (int i = 0; i < events_per_step && !done; ++i) {
    EventRecord event;
    ILP_TAKE(const Found found, find_next(wiring_.store, request.mark_id, event));
    if (found == Found::nothing) return {};
    request.mark_id = event.id;
    done = event.code == static_cast<std::uint16_t>(StatusCode::component_restarted) && event.a == request.subject_id;
  }
  return {};
}

void Telecommander::report_news(const News& news) {
  Answer answer(wiring_.writer, {news.request.packet, news.request.source}, news.request.ack_flags);
  if (news.kind == News::Kind::begun) {
    answer.start();
    return;
  }
  answer.continue_started();
  if (news.kind == News::Kind::progress) {
    answer.progress(news.request.settled % 256U);
  } else {
    answer.finish(news.status);
  }
}

}  // namespace ilp
