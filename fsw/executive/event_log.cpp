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

void EventLog::report_lost(TimeNs time) {
  if (state_.untold == 0) return;
  Allowance& allowance = allowance_of(time, own_name, StatusCode::events_lost);
  if (!allows(allowance, time)) return;
  if (write(time, own_name,
            {StatusCode::events_lost, state_.untold,
             static_cast<std::int64_t>(static_cast<std::uint16_t>(state_.first_untold))})) {
    state_.untold = 0;
    allowance.used_until_ns += interval_ns;
  }
}

void EventLog::report_counted(TimeNs time, Allowance& allowance) {
  if (allowance.counted == 0) return;
  if (write(time, allowance.component,
            {StatusCode::events_repeated, allowance.counted,
             static_cast<std::int64_t>(static_cast<std::uint16_t>(allowance.code))})) {
    allowance.counted = 0;
  }
}

void EventLog::report_due(TimeNs time) {
  check();
  report_lost(time);
  for (Allowance& allowance : state_.allowances) {
    const TimeNs since = allowance.counted_since_ns;
    if (time < since || time - since >= interval_ns) report_counted(time, allowance);
  }
  guard_.seal(state_);
}

void EventLog::report_rest(TimeNs time) {
  check();
  report_lost(time);
  for (Allowance& allowance : state_.allowances) report_counted(time, allowance);
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
    if (!write(time, component, status)) {
      ++state_.lost;
      if (state_.untold++ == 0) state_.first_untold = status.code;
    }
  }
  guard_.seal(state_);
}

bool EventLog::write(TimeNs time, const char* component, const Status& status) {
  EventRecord record;
  record.time_ns = time;
  record.code = static_cast<std::uint16_t>(status.code);
  record.severity = static_cast<std::uint8_t>(status_severity(status.code));
  copy_text(record.component, component);
  record.a = status.a;
  record.b = status.b;
  if (status.is(StatusCode::assertion_failed)) copy_text(record.place, base_name(last_assertion().file));
  return write(record).ok();
}

/// Another process may write events too, so the number is drawn within the transaction.
Status EventLog::write(EventRecord& record) {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(newest_id<EventRecord>(store_, record.id));
  ++record.id;
  ILP_TRY(put(store_, record));
  return transaction.commit();
}

}  // namespace ilp
