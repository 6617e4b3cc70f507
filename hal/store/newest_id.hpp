// Ids of a table: the newest one, the first one of a store epoch, and ids in telecommands.
#pragma once

#include "hal/store/store_view.hpp"

namespace ilp {

/// Sets `id` to the id of the newest record, damaged or not, but at least to Store::id_base(). An empty table is no
/// error. Returns faults of the store.
template <typename Record>
Status newest_id(Reader<Record> store, std::int64_t& id) {
  Record record;
  const Status found = last(store, record);
  const bool damaged = found.is(StatusCode::record_damaged);
  id = store.id_base(record_type<Record>);
  if (found.ok() && record.id > id) id = record.id;
  if (damaged && found.a > id) id = found.a;
  return damaged || found.is(StatusCode::not_found) ? Status{} : found;
}

/// Raises a counter of `Record` ids, or a cursor over them, to Store::id_base() if it is smaller. `AnyStore` is a Store
/// or a part of one. Nothing is read.
template <typename Record, typename AnyStore>
void begin_ids(const AnyStore& store, std::int64_t& id) {
  const std::int64_t base = store.id_base(record_type<Record>);
  if (id < base) id = base;
}

/// Returns the id that a telecommand names. A number up to Store::id_base() counts within this store epoch; a larger
/// one is an id.
template <typename Record, typename AnyStore>
std::int64_t number_in_store_epoch(const AnyStore& store, std::int64_t number) {
  const std::int64_t base = store.id_base(record_type<Record>);
  return number <= base ? base + number : number;
}

}  // namespace ilp
