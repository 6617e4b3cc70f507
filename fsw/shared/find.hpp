// Reads records that a stage can do without. A record that is gone or damaged counts as not found, so that the stage
// skips it. Any other fault of a read says nothing about the record: the stage tries again, as long as Patience allows.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Interprets the status of a read: true if the record was read, false if it is gone or damaged, otherwise the fault.
[[nodiscard]] inline Result<bool> read_by(const Status& status) {
  if (!status.ok() && !is_gone(status)) return status;
  return status.ok();
}
/// Interprets the status of work on a record: true if it succeeded, false after a final fault (the same input would
/// cause it again), otherwise the transient fault.
[[nodiscard]] inline Result<bool> found_by(const Status& status) {
  if (is_transient(status)) return status;
  return status.ok();
}

/// Reads the record of this id. Returns false, and leaves `record` unchanged, if it is gone or damaged.
template <typename Record>
Result<bool> find(Reader<Record> store, std::int64_t id, Record& record) {
  return read_by(get(store, id, record));
}

enum class Found : std::uint8_t {
  nothing,
  valid,
  damaged  ///< only the record's id is known
};

/// Reads the first record with an id above `after`, for readers that go on after a damaged record. Returns only faults
/// that say nothing about the record.
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
