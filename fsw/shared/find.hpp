// Records that a stage can do without. A fault that may pass is returned, so that the stage waits; a record that is
// gone or damaged is none, so that the stage skips it. Patience says when a stage gives up.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// `status` of a read: yes, no, or a fault that may pass.
[[nodiscard]] inline Result<bool> found_by(const Status& status) {
  if (is_transient(status)) return status;
  return status.ok();
}

/// The record of this id. It is written only where it is found.
template <typename Record>
Result<bool> find(Reader<Record> store, std::int64_t id, Record& record) {
  return found_by(get(store, id, record));
}

enum class Found : std::uint8_t {
  nothing,
  sound,
  damaged  ///< only the record's id is known
};

/// The first record after `after`, for readers that go on after a damaged one. Returns only faults that are none of the
/// record's own.
template <typename Record>
Result<Found> find_next(Reader<Record> store, std::int64_t after, Record& record) {
  const Status status = next(store, after, record);
  if (status.ok()) return Found::sound;
  if (status.is(StatusCode::not_found)) return Found::nothing;
  if (!status.is(StatusCode::record_damaged)) return status;
  record = {};
  record.id = status.a;
  return Found::damaged;
}

}  // namespace ilp
