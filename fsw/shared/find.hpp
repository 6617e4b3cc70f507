// Records that a stage can do without. One that is gone or damaged is none, so that the stage skips it. Any other fault
// of a read says nothing about the record: the stage waits. Patience says when a stage gives up.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// `status` of a read: yes, no, or a fault that is none of the record's own.
[[nodiscard]] inline Result<bool> read_by(const Status& status) {
  if (!status.ok() && !is_gone(status)) return status;
  return status.ok();
}
/// `status` of work on what was read: every final fault is a no, because the same input would meet it again.
[[nodiscard]] inline Result<bool> found_by(const Status& status) {
  if (is_transient(status)) return status;
  return status.ok();
}

/// The record of this id. It is written only where it is found.
template <typename Record>
Result<bool> find(Reader<Record> store, std::int64_t id, Record& record) {
  return read_by(get(store, id, record));
}

enum class Found : std::uint8_t {
  nothing,
  valid,
  damaged  ///< only the record's id is known
};

/// The first record after `after`, for readers that go on after a damaged one. Returns only faults that are none of the
/// record's own.
template <typename Record>
Result<Found> find_next(Reader<Record> store, std::int64_t after, Record& record) {
  const Status status = next(store, after, record);
  if (status.ok()) return Found::valid;
  if (status.is(StatusCode::not_found)) return Found::nothing;
  if (!status.is(StatusCode::record_damaged)) return status;
  record = {};
  record.id = status.a;
  return Found::damaged;
}

}  // namespace ilp
