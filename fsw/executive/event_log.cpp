#include "fsw/executive/event_log.hpp"

#include "fsw/base/text.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {

Status EventLog::number() {
  if (state_.numbered) return {};
  ILP_TRY(newest_id<EventRecord>(store_, state_.last_id));
  state_.numbered = true;
  return {};
}

/// A number that is too small would overwrite reported events.
void EventLog::check() {
  if (guard_.check(state_) == GuardFinding::lost) state_ = {};
}

void EventLog::report_lost(TimeNs time) {
  check();
  if (state_.untold == 0) return;
  if (write(time, "executive",
            {StatusCode::events_lost, state_.untold,
             static_cast<std::int64_t>(static_cast<std::uint16_t>(state_.first_untold))})) {
    state_.untold = 0;
  }
  guard_.seal(state_);
}

void EventLog::report(TimeNs time, const char* component, const Status& status) {
  report_lost(time);
  if (!write(time, component, status)) {
    ++state_.lost;
    if (state_.untold++ == 0) state_.first_untold = status.code;
  }
  guard_.seal(state_);
}

bool EventLog::write(TimeNs time, const char* component, const Status& status) {
  if (!number().ok()) return false;
  EventRecord record;
  record.id = state_.last_id + 1;
  record.time_ns = time;
  record.code = static_cast<std::uint16_t>(status.code);
  record.severity = static_cast<std::uint8_t>(status_severity(status.code));
  copy_text(record.component, component);
  record.a = status.a;
  record.b = status.b;
  if (status.is(StatusCode::assertion_failed)) copy_text(record.place, base_name(last_assertion().file));
  Transaction transaction(store_);
  if (!transaction.begin().ok() || !put(store_, record).ok() || !transaction.commit().ok()) return false;
  ++state_.last_id;
  return true;
}

}  // namespace ilp
