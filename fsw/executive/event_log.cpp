#include "fsw/executive/event_log.hpp"

#include "fsw/base/text.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {

void EventLog::check() {
  if (guard_.check(state_) == GuardFinding::lost) state_ = {};
}

void EventLog::lose(const Status& status) {
  ++state_.lost;
  if (state_.untold++ == 0) state_.first_untold = status.code;
}

void EventLog::write_waiting() {
  auto& waiting = state_.waiting;
  std::size_t done = 0;
  for (; done < waiting.size(); ++done) {
    const Status written = write(waiting[done]);
    if (written.is(StatusCode::store_locked)) break;
    if (!written.ok()) lose(waiting[done].status);
  }
  const std::size_t left = waiting.size() - done;
  for (std::size_t i = 0; i < left; ++i) waiting[i] = waiting[done + i];
  while (waiting.size() > left) waiting.pop_back();
}

void EventLog::report_lost(TimeNs time) {
  check();
  write_waiting();
  const bool told = state_.untold != 0 && state_.waiting.empty() &&
                    write({time,
                           "executive",
                           {StatusCode::events_lost, state_.untold,
                            static_cast<std::int64_t>(static_cast<std::uint16_t>(state_.first_untold))}})
                        .ok();
  if (told) state_.untold = 0;
  guard_.seal(state_);
}

void EventLog::report(TimeNs time, const char* component, const Status& status) {
  report_lost(time);
  const Waiting event{time, component, status};
  const Status written = state_.waiting.empty() ? write(event) : Status{StatusCode::store_locked};
  const bool waits = written.is(StatusCode::store_locked) && state_.waiting.push_back(event);
  if (!written.ok() && !waits) lose(status);
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
  if (status.is(StatusCode::assertion_failed)) copy_text(record.place, base_name(last_assertion().file));
  return write(record);
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
