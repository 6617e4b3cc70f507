// How far the numbering of a kind of record has come.
#pragma once

#include "hal/store/store.hpp"

namespace ilp {

/// Id of the newest record, 0 where there is none. Faults of the store are passed on.
template <typename Record>
Status newest_id(Store& store, std::int64_t& id) {
  Record record;
  const Status found = last(store, record);
  id = found.ok() ? record.id : 0;
  return found.is(StatusCode::not_found) ? Status{} : found;
}

}  // namespace ilp
