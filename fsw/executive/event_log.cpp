#include "fsw/executive/event_log.hpp"

#include "fsw/base/text.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {

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
