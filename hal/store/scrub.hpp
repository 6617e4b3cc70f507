// Reads the complete store in small slices, so that damage is found while the damaged data can still be recovered.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "hal/store/record_bytes.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Position in a round, which reads every table once. Value initialisation begins a round.
struct ScrubCursor {
  std::size_t table = 0;                                          ///< RecordType as a number
  std::int64_t after = std::numeric_limits<std::int64_t>::min();  ///< id of the record that was read last
  std::size_t blob = 0;    ///< number of that record's next blob, from 1; 0: all blobs were read
  std::size_t offset = 0;  ///< next byte in that blob
};

/// The result of one slice.
struct ScrubSlice {
  /// The damage that ended the slice, or ok. `record_damaged` (first value: id, second: RecordType) names a record that
  /// is damaged or has a damaged blob; the next slice continues after that record or blob. After `store_damaged` the
  /// next slice continues with the next table.
  Status damage;
  /// The fault that made reading impossible, or ok. The next slice tries the same position again.
  Status fault;
  std::uint32_t records = 0;    ///< records that were read
  std::size_t bytes = 0;        ///< bytes of records and blobs that were read
  bool round_complete = false;  ///< the last table was read to its end; the next slice begins a round
};

/// May read every table.
using WholeReader = StoreView<StoreAccess{.reads = mask_of(RecordType::count) - 1}>;

namespace detail {

inline void scrub_next_table(ScrubCursor& cursor, ScrubSlice& slice) {
  const std::size_t table = cursor.table + 1;
  cursor = {};
  cursor.table = table;
  if (table < static_cast<std::size_t>(RecordType::count)) return;
  cursor.table = 0;
  slice.round_complete = true;
}

/// Enters a failed read into the slice. `where` is the position after the record or blob that was read.
inline void scrub_found(const Status& status, ScrubCursor& cursor, const ScrubCursor& where, ScrubSlice& slice) {
  if (status.is(StatusCode::record_damaged)) {
    slice.damage = status;
    cursor = where;
  } else if (status.is(StatusCode::store_damaged)) {
    slice.damage = status;
    scrub_next_table(cursor, slice);
  } else {
    slice.fault = status;
  }
}

inline void scrub_record(WholeReader store, const RecordInfo& info, ScrubCursor& cursor, ScrubSlice& slice) {
  alignas(8) std::uint8_t record[limits::max_record_bytes];
  const Status found = store.next(info, cursor.after, record);
  ScrubCursor next_place = cursor;
  if (found.ok()) {
    ++slice.records;
    slice.bytes += info.bytes;
    next_place.after = id_of(record);
    next_place.blob = 1;
    cursor = next_place;
  } else if (found.is(StatusCode::not_found)) {
    scrub_next_table(cursor, slice);
  } else {
    next_place.after = found.a;
    scrub_found(found, cursor, next_place, slice);
  }
}

inline void scrub_blob(WholeReader store, const RecordInfo& info, std::span<std::uint8_t> scratch, ScrubCursor& cursor,
                       ScrubSlice& slice) {
  const FieldInfo* field = nullptr;
  for_each_blob(info, [&](const FieldInfo& candidate, std::size_t index) {
    if (index + 1 == cursor.blob) field = &candidate;
  });
  ScrubCursor next_place = cursor;
  next_place.blob = 0;
  next_place.offset = 0;
  alignas(8) std::uint8_t record[limits::max_record_bytes];
  const Status found = field != nullptr ? store.get(info, cursor.after, record) : Status{StatusCode::not_found};
  if (found.is(StatusCode::not_found)) {  // no blob is left, or the record was erased since
    cursor = next_place;
    return;
  }
  if (!found.ok()) return scrub_found(found, cursor, next_place, slice);
  const std::size_t size = blob_bytes(record, *field);
  next_place.blob = cursor.blob + 1;
  if (cursor.offset >= size) {
    cursor = next_place;
    return;
  }
  const std::size_t chunk = size - cursor.offset < scratch.size() ? size - cursor.offset : scratch.size();
  const Status read = store.read_blob(info, field->name, cursor.after, cursor.offset, scratch.first(chunk));
  if (!read.ok()) return scrub_found(read, cursor, next_place, slice);
  slice.bytes += chunk;
  cursor.offset += chunk;
}

}  // namespace detail

/// Reads one slice: until `max_bytes` have been read, damage was found or the round is complete. `scratch` holds the
/// bytes of one read and has at least a few KiB. A slice exceeds `max_bytes` by at most one record or the size of
/// `scratch`. Records may be put and erased between the slices of a round.
inline ScrubSlice scrub(WholeReader store, std::size_t max_bytes, std::span<std::uint8_t> scratch,
                        ScrubCursor& cursor) {
  ScrubSlice slice;
  if (scratch.empty() || cursor.table >= static_cast<std::size_t>(RecordType::count)) cursor = {};
  while (!scratch.empty() && slice.bytes < max_bytes && slice.damage.ok() && slice.fault.ok() &&
         !slice.round_complete) {
    const RecordInfo& info = record_info(static_cast<RecordType>(cursor.table));
    if (cursor.blob == 0) {
      detail::scrub_record(store, info, cursor, slice);
    } else {
      detail::scrub_blob(store, info, scratch, cursor, slice);
    }
  }
  return slice;
}

}  // namespace ilp
