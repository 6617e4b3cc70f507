// The present end of the numbering of a kind of record.
#pragma once

#include "hal/store/store_view.hpp"

namespace ilp {

/// Id of the newest record, damaged or not, but at least the number after which ids of this store epoch begin.
/// Returns faults of the store.
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

/// A new counter or cursor over the ids of `Record` begins with this store epoch. `AnyStore` is a Store or any
/// part of one; nothing is read.
template <typename Record, typename AnyStore>
void begin_ids(const AnyStore& store, std::int64_t& id) {
  const std::int64_t base = store.id_base(record_type<Record>);
  if (id < base) id = base;
}

/// Expands a number from a telecommand, which may be a short one of this store epoch or a whole one.
template <typename Record, typename AnyStore>
std::int64_t number_in_store_epoch(const AnyStore& store, std::int64_t number) {
  const std::int64_t base = store.id_base(record_type<Record>);
  return number <= base ? base + number : number;
}

}  // namespace ilp
