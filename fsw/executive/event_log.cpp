#include "fsw/executive/event_log.hpp"

#include "fsw/base/text.hpp"

namespace ilp {

Status EventLog::restore() {
  EventRecord record;
  const Status status = last(store_, record);
  last_id_ = status.ok() ? record.id : 0;
  return status.is(StatusCode::not_found) ? Status{} : status;
}

void EventLog::report_lost(TimeNs time) {
  if (untold_ == 0) return;
  if (write(time, "executive",
            {StatusCode::events_lost, untold_, static_cast<std::int64_t>(static_cast<std::uint16_t>(first_untold_))})) {
    untold_ = 0;
  }
}

void EventLog::report(TimeNs time, const char* component, const Status& status) {
  report_lost(time);
  if (write(time, component, status)) return;
  ++lost_;
  if (untold_++ == 0) first_untold_ = status.code;
}

bool EventLog::write(TimeNs time, const char* component, const Status& status) {
  EventRecord record;
  record.id = last_id_ + 1;
  record.time_ns = time;
  record.code = static_cast<std::uint16_t>(status.code);
  record.severity = static_cast<std::uint8_t>(status_severity(status.code));
  copy_text(record.component, component);
  record.a = status.a;
  record.b = status.b;
  if (status.is(StatusCode::assertion_failed)) copy_text(record.place, base_name(last_assertion().file));
  Transaction transaction(store_);
  if (!transaction.begin().ok() || !put(store_, record).ok() || !transaction.commit().ok()) return false;
  ++last_id_;
  return true;
}

}  // namespace ilp
