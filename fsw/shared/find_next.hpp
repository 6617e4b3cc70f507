// The next record of a table, for readers that go on after a damaged one.
#pragma once

#include "hal/store/store_view.hpp"

namespace ilp {

enum class Found : std::uint8_t {
  nothing,
  sound,
  damaged  ///< only the record's id is known
};

/// The first record after `after`. Returns only faults that are none of the record's own.
template <typename Record>
Status find_next(Reader<Record> store, std::int64_t after, Record& record, Found& found) {
  const Status status = next(store, after, record);
  found = status.ok() ? Found::sound : Found::nothing;
  if (status.ok() || status.is(StatusCode::not_found)) return {};
  if (!status.is(StatusCode::record_damaged)) return status;
  found = Found::damaged;
  record = {};
  record.id = status.a;
  return {};
}

}  // namespace ilp
