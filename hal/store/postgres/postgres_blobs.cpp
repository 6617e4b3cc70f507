// Reads and writes blobs of the store on a server. A few blobs are kept in memory (HeldBlobs), so that calls for parts
// of a blob need no round trip each.
#include <algorithm>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/postgres/session.hpp"

namespace ilp::postgres {
namespace {

/// A smaller blob is not kept when it is written: few of them are read again.
constexpr std::size_t least_kept_bytes = std::size_t{128} << 10U;

Status damaged(const BlobName& blob) {
  return {StatusCode::record_damaged, blob.id, static_cast<std::int64_t>(blob.type)};
}

std::span<const std::uint8_t> chunk_of(std::span<const std::uint8_t> bytes, std::size_t chunk) {
  const std::size_t begin = chunk * blob_chunk_bytes;
  return bytes.subspan(begin, std::min(blob_chunk_bytes, bytes.size() - begin));
}

ChunkSum sum_of(const BlobName& blob, std::size_t chunk, std::span<const std::uint8_t> bytes) {
  ChunkSum sum(blob, chunk);
  sum.add(bytes);
  return sum;
}

void add_sums(const BlobName& blob, std::span<const std::uint8_t> bytes, std::uint8_t* sums) {
  for (std::size_t chunk = 0; chunk < chunk_count(blob.bytes); ++chunk) {
    store_little_endian(sum_of(blob, chunk, chunk_of(bytes, chunk)).value(), sums + 4 * chunk);
  }
}

void take_place(HeldBlobs& blobs) {
  blobs.latest = blobs.places.data();
  for (HeldBlob& held : blobs.places) {
    const bool empty = held.name.type == RecordType::count;
    const bool earlier = held.used < blobs.latest->used;
    if (blobs.latest->name.type != RecordType::count && (empty || earlier)) blobs.latest = &held;
  }
  blobs.latest->forget();
  blobs.latest->used = ++blobs.uses;
}

std::span<std::uint8_t> held_chunk(HeldBlob& held, std::size_t chunk) {
  const std::size_t begin = chunk * blob_chunk_bytes;
  return std::span(held.bytes).subspan(begin, std::min(blob_chunk_bytes, held.name.bytes - begin));
}

bool chunk_is_valid(const HeldBlob& held, std::size_t chunk) {
  const auto bytes = chunk_of(std::span(held.bytes).first(held.name.bytes), chunk);
  return sum_of(held.name, chunk, bytes).matches(load_little_endian<std::uint32_t>(held.sums.data() + 4 * chunk));
}

void set_sum(HeldBlob& held, std::size_t chunk) {
  store_little_endian(sum_of(held.name, chunk, held_chunk(held, chunk)).value(), held.sums.data() + 4 * chunk);
}

Status send_fill(Session& s, const BlobName& blob, std::span<const std::uint8_t> sums,
                 std::span<const std::uint8_t> bytes) {
  ILP_TRY(start(s));
  ILP_TRY(make_room(s));
  Parameters parameters;
  parameters.add(blob.id).add(static_cast<std::int64_t>(blob.bytes));
  parameters.add_bytes(sums.data(), sums.size()).add_bytes(bytes.data(), bytes.size());
  return send(s, BlobVerb::fill, record_info(blob.type), blob.index, parameters, false);
}

/// The blob of a record does not have the size that the record states.
Status stated_size(Session& s, const RecordInfo& info, const BlobName& blob, std::size_t bytes) {
  alignas(8) unsigned char record[limits::max_record_bytes];
  ILP_TRY(get(s, info, blob.id, record));
  std::size_t stated = 0;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    if (index == blob.index) stated = blob_bytes(record, field);
  });
  return stated == bytes ? Status{} : damaged(blob);
}

Status check_range(Session& s, const RecordInfo& info, const BlobName& blob, std::size_t offset, std::size_t bytes) {
  if (offset <= blob.bytes && bytes <= blob.bytes - offset) return {};
  ILP_TRY(stated_size(s, info, blob, blob.bytes));
  return out_of_range(Argument::blob_range, blob.bytes);
}

/// Takes the blob out of the answer.
Status take_blob(Session& s, BlobName& blob) {
  const Rows& rows = s.connection.rows(s.awaited.answer);
  std::int64_t size = 0;
  std::int64_t length = 0;
  std::span<const std::uint8_t> sums;
  std::span<const std::uint8_t> bytes;
  if (!rows.number(0, 0, size) || !rows.bytes(0, 1, sums) || !rows.bytes(0, 2, bytes) || !rows.number(0, 3, length)) {
    return damaged(blob);
  }
  const bool fits = size > 0 && size <= std::int64_t{max_postgres_blob_bytes};
  if (!fits || (length != 0 && length != size) || static_cast<std::size_t>(length) != bytes.size())
    return damaged(blob);
  blob.bytes = static_cast<std::size_t>(size);
  if (!sums.empty() && sums.size() != 4 * chunk_count(blob.bytes)) return damaged(blob);
  std::memset(s.blobs.latest->sums.data(), 0, 4 * chunk_count(blob.bytes));
  std::copy(sums.begin(), sums.end(), s.blobs.latest->sums.begin());
  if (bytes.empty()) std::memset(s.blobs.latest->bytes.data(), 0, blob.bytes);
  std::copy(bytes.begin(), bytes.end(), s.blobs.latest->bytes.begin());
  s.blobs.latest->name = blob;
  return {};
}

Status hold_blob(Session& s, const RecordInfo& info, BlobName& blob) {
  if (!s.connection.alive()) return StatusCode::store_lost;
  if (s.transaction.open && !s.transaction.doomed.ok()) return s.transaction.doomed;
  // In a transaction it has to be the newest state.
  ILP_TRY(start(s));
  if (s.transaction.open && s.awaited.look != no_place) ILP_TRY(collect(s));
  HeldBlob* const known = find_held(s, blob);
  if (known != s.blobs.latest) ILP_TRY(send_held_blob(s));
  if (known != nullptr) {
    s.blobs.latest = known;
    blob.bytes = known->name.bytes;
    return {};
  }
  if (s.transaction.open) ILP_TRY(send_latest_sizes(s));
  take_place(s.blobs);
  ILP_TRY(make_room(s));
  Parameters parameters;
  parameters.add(blob.id).add(static_cast<std::int64_t>(max_postgres_blob_bytes));
  s.awaited.answer = s.connection.next_place();
  ILP_TRY(send(s, BlobVerb::read, info, blob.index, parameters, true));
  ILP_TRY(collect_answer(s));
  if (s.connection.rows(s.awaited.answer).count() == 0) {
    s.connection.clear();
    ILP_TRY(stated_size(s, info, blob, 0));
    return {StatusCode::not_found, blob.id};
  }
  const Status status = take_blob(s, blob);
  s.connection.clear();
  return status;
}

/// The size of a blob that was put in this transaction is known without the server.
Status size_for_write(Session& s, const RecordInfo& info, BlobName& blob) {
  if (s.transaction.latest.info != &info || s.transaction.latest.id != blob.id) return hold_blob(s, info, blob);
  blob.bytes = s.transaction.latest.bytes[blob.index];
  return blob.bytes != 0 ? Status{} : Status{StatusCode::not_found, blob.id};
}

Status write_whole(Session& s, const BlobName& blob, std::span<const std::uint8_t> bytes) {
  if (s.transaction.latest.info == &record_info(blob.type) && s.transaction.latest.id == blob.id)
    s.transaction.latest.sent[blob.index] = true;
  HeldBlob* const known = find_held(s, blob);
  if (known != s.blobs.latest) ILP_TRY(send_held_blob(s));
  if (known != nullptr) known->forget();
  if (blob.bytes < least_kept_bytes) {
    std::array<std::uint8_t, 4 * chunk_count(least_kept_bytes)> sums;
    add_sums(blob, bytes, sums.data());
    return send_fill(s, blob, std::span(sums).first(4 * chunk_count(blob.bytes)), bytes);
  }
  take_place(s.blobs);
  add_sums(blob, bytes, s.blobs.latest->sums.data());
  std::copy(bytes.begin(), bytes.end(), s.blobs.latest->bytes.begin());
  s.blobs.latest->name = blob;
  return send_fill(s, blob, std::span(s.blobs.latest->sums).first(4 * chunk_count(blob.bytes)), bytes);
}

/// The rest of a partly written chunk must have its checksum.
Status write_part(HeldBlob& held, std::size_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const std::size_t end = offset + bytes.size();
  const std::size_t last = (end - 1) / blob_chunk_bytes;
  for (std::size_t chunk = offset / blob_chunk_bytes; chunk <= last; ++chunk) {
    const std::size_t begin = chunk * blob_chunk_bytes;
    const bool whole = offset <= begin && end >= begin + held_chunk(held, chunk).size();
    if (!whole && !chunk_is_valid(held, chunk)) return damaged(held.name);
  }
  std::copy(bytes.begin(), bytes.end(), held.bytes.begin() + static_cast<std::ptrdiff_t>(offset));
  for (std::size_t chunk = offset / blob_chunk_bytes; chunk <= last; ++chunk) set_sum(held, chunk);
  held.changed = true;
  return {};
}

Status read_part(const HeldBlob& held, std::size_t offset, std::span<std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const std::size_t last = (offset + bytes.size() - 1) / blob_chunk_bytes;
  for (std::size_t chunk = offset / blob_chunk_bytes; chunk <= last; ++chunk) {
    if (!chunk_is_valid(held, chunk)) return damaged(held.name);
  }
  std::copy_n(held.bytes.begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
  return {};
}

}  // namespace

HeldBlob* find_held(Session& s, const BlobName& blob) {
  for (HeldBlob& held : s.blobs.places) {
    if (held.name.type != blob.type || held.name.index != blob.index || held.name.id != blob.id) continue;
    held.used = ++s.blobs.uses;
    return &held;
  }
  return nullptr;
}

void drop_held_of(Session& s, RecordType type, std::int64_t id) {
  for (HeldBlob& held : s.blobs.places) {
    if (held.name.type == type && held.name.id == id) held.forget();
  }
}

void drop_held(Session& s, RecordMask tables) {
  for (HeldBlob& held : s.blobs.places) {
    if (held.name.type == RecordType::count || (tables & mask_of(held.name.type)) == 0) continue;
    held.forget();
  }
}

Status send_latest_sizes(Session& s) {
  LatestPut& latest = s.transaction.latest;
  if (latest.info == nullptr) return {};
  ILP_TRY(start(s));
  ILP_TRY(make_room(s));
  Status status;
  for_each_blob(*latest.info, [&](const FieldInfo&, std::size_t blob) {
    if (latest.sent[blob] || !status.ok()) return;
    latest.sent[blob] = true;
    Parameters parameters;
    parameters.add(latest.id);
    if (latest.bytes[blob] != 0) parameters.add(std::int64_t{latest.bytes[blob]});
    const BlobVerb verb = latest.bytes[blob] != 0 ? BlobVerb::resize : BlobVerb::erase;
    status = send(s, verb, *latest.info, blob, parameters, false);
  });
  return status;
}

Status send_held_blob(Session& s) {
  HeldBlob& held = *s.blobs.latest;
  if (!held.changed) return {};
  held.changed = false;
  return send_fill(s, held.name, std::span(held.sums).first(4 * chunk_count(held.name.bytes)),
                   std::span(held.bytes).first(held.name.bytes));
}

Status write_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                  std::span<const std::uint8_t> bytes) {
  ILP_TRY(writable(s));
  BlobName blob{info.type, find_blob(info, field), id, 0};
  if (blob.index == max_blob_fields) return out_of_range(Argument::blob_field);
  Status status = size_for_write(s, info, blob);
  if (status.ok()) status = check_range(s, info, blob, offset, bytes.size());
  if (status.is(StatusCode::invalid_argument) || status.is(StatusCode::not_found)) return status;
  if (status.ok() && bytes.size() == blob.bytes) return written(s, info, write_whole(s, blob, bytes));
  if (status.ok()) status = hold_blob(s, info, blob);
  if (status.ok()) status = write_part(*s.blobs.latest, offset, bytes);
  return written(s, info, status);
}

Status read_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                 std::span<std::uint8_t> bytes) {
  BlobName blob{info.type, find_blob(info, field), id, 0};
  if (blob.index == max_blob_fields) return out_of_range(Argument::blob_field);
  const HeldBlob* const known = find_held(s, blob);
  const bool was_held = known != nullptr && !known->changed;
  ILP_TRY(hold_blob(s, info, blob));
  ILP_TRY(check_range(s, info, blob, offset, bytes.size()));
  Status status = read_part(*s.blobs.latest, offset, bytes);
  if (status.is(StatusCode::record_damaged) && was_held) {
    // A bit may have flipped here and not in the store.
    s.blobs.latest->name = {};
    ILP_TRY(hold_blob(s, info, blob));
    status = read_part(*s.blobs.latest, offset, bytes);
  }
  if (!status.ok()) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  return status;
}

}  // namespace ilp::postgres
