#include "fsw/executive/event_log.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/text.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr const char* own_name = "executive";

}  // namespace

void EventLog::check() {
  if (guard_.check(state_) == GuardFinding::lost) state_ = {};
}

EventLog::Allowance& EventLog::allowance_of(TimeNs time, const char* component, StatusCode code) {
  static_assert(sizeof(Allowance::component) == sizeof(EventRecord::component));
  char name[sizeof(Allowance::component)];
  copy_text(name, component);
  for (Allowance& known : state_.allowances) {
    if (known.code == code && std::strcmp(known.component, name) == 0) return known;
  }
  Allowance& place = *std::min_element(
      state_.allowances.begin(), state_.allowances.end(),
      [](const Allowance& one, const Allowance& other) { return one.used_until_ns < other.used_until_ns; });
  report_counted(time, place);
  if (place.counted > 0) lose(place.code, place.counted);
  place = {};
  copy_text(place.component, component);
  place.code = code;
  return place;
}

bool EventLog::allows(Allowance& allowance, TimeNs time) {
  const TimeNs used = allowance.used_until_ns - time;
  // More than a whole allowance cannot be used, unless the time was set back.
  if (used <= 0 || used > burst * interval_ns) allowance.used_until_ns = time;
  return allowance.used_until_ns - time <= (burst - 1) * interval_ns;
}

void EventLog::lose(StatusCode code, std::int64_t events) {
  state_.lost += static_cast<std::uint32_t>(events);
  if (state_.untold == 0) state_.first_untold = code;
  state_.untold += static_cast<std::uint32_t>(events);
}

void EventLog::write_waiting() {
  auto& waiting = state_.waiting;
  std::size_t done = 0;
  for (; done < waiting.size(); ++done) {
    const Status written = write(waiting[done]);
    if (written.is(StatusCode::store_locked)) break;
    if (!written.ok()) lose(waiting[done].status.code, 1);
  }
  const std::size_t left = waiting.size() - done;
  for (std::size_t i = 0; i < left; ++i) waiting[i] = waiting[done + i];
  while (waiting.size() > left) waiting.pop_back();
}

void EventLog::report_lost(TimeNs time) {
  write_waiting();
  if (state_.untold == 0 || !state_.waiting.empty()) return;
  Allowance& allowance = allowance_of(time, own_name, StatusCode::events_lost);
  if (!allows(allowance, time)) return;
  const Status lost{StatusCode::events_lost, state_.untold, static_cast<std::int64_t>(state_.first_untold)};
  if (!write({time, own_name, lost}).ok()) return;
  state_.untold = 0;
  allowance.used_until_ns += interval_ns;
}

void EventLog::report_counted(TimeNs time, Allowance& allowance) {
  if (allowance.counted == 0) return;
  const auto code = static_cast<std::int64_t>(allowance.code);
  const Status repeated{StatusCode::events_repeated, allowance.counted, code};
  if (write({time, allowance.component, repeated}).ok()) allowance.counted = 0;
}

void EventLog::report_due(TimeNs time, bool ends) {
  check();
  report_lost(time);
  for (Allowance& allowance : state_.allowances) {
    const TimeNs since = allowance.counted_since_ns;
    if (ends || time < since || time - since >= interval_ns) report_counted(time, allowance);
  }
  guard_.seal(state_);
}

void EventLog::report(TimeNs time, const char* component, const Status& status) {
  check();
  report_lost(time);
  Allowance& allowance = allowance_of(time, component, status.code);
  if (!allows(allowance, time)) {
    if (allowance.counted++ == 0) allowance.counted_since_ns = time;
  } else {
    allowance.used_until_ns += interval_ns;
    const bool asserted = status.is(StatusCode::assertion_failed);
    const Waiting event{time, component, status, asserted ? base_name(last_assertion().file) : ""};
    const Status written = state_.waiting.empty() ? write(event) : Status{StatusCode::store_locked};
    const bool waits = written.is(StatusCode::store_locked) && state_.waiting.push_back(event);
    if (!written.ok() && !waits) lose(status.code, 1);
  }
  guard_.seal(state_);
}

Status EventLog::write(const Waiting& event) {
  const Status& status = event.status;
  EventRecord record;
  record.time_ns = event.time_ns;
  record.code = static_cast<std::uint16_t>(status.code);
  record.severity = static_cast<std::uint8_t>(status_severity(status.code));
  copy_text(record.component, event.component);
  record.a = status.a;
  record.b = status.b;
  copy_text(record.place, event.place);
  // Another process may write events too, so the number is drawn within the transaction.
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(newest_id<EventRecord>(store_, record.id));
  ++record.id;
  ILP_TRY(put(store_, record));
  return transaction.commit();
}

}  // namespace ilp
