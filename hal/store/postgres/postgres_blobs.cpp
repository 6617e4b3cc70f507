// Blobs of the store on a server. One blob is held here, so that it is read and written in pieces without a round trip
// for each.
#include <algorithm>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/postgres/postgres_store.hpp"

namespace ilp {

using namespace postgres;

namespace {

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

}  // namespace

PostgresStore::HeldBlob* PostgresStore::find_held(const BlobName& blob) {
  for (HeldBlob& held : blobs_) {
    if (held.name.type != blob.type || held.name.index != blob.index || held.name.id != blob.id) continue;
    held.used = ++blob_uses_;
    return &held;
  }
  return nullptr;
}

void PostgresStore::take_place() {
  held_ = blobs_.data();
  for (HeldBlob& held : blobs_) {
    const bool empty = held.name.type == RecordType::count;
    if (held_->name.type != RecordType::count && (empty || held.used < held_->used)) held_ = &held;
  }
  held_->forget();
  held_->used = ++blob_uses_;
}

void PostgresStore::drop_held_of(RecordType type, std::int64_t id) {
  for (HeldBlob& held : blobs_) {
    if (held.name.type == type && held.name.id == id) held.forget();
  }
}

void PostgresStore::drop_held(RecordMask tables) {
  for (HeldBlob& held : blobs_) {
    if (held.name.type == RecordType::count || (tables & mask_of(held.name.type)) == 0) continue;
    held.forget();
  }
}

std::span<std::uint8_t> PostgresStore::held_chunk(std::size_t chunk) {
  const std::size_t begin = chunk * blob_chunk_bytes;
  return std::span(held_->bytes).subspan(begin, std::min(blob_chunk_bytes, held_->name.bytes - begin));
}

bool PostgresStore::chunk_is_sound(std::size_t chunk) const {
  const auto bytes = chunk_of(std::span(held_->bytes).first(held_->name.bytes), chunk);
  return sum_of(held_->name, chunk, bytes).matches(load_little_endian<std::uint32_t>(held_->sums.data() + 4 * chunk));
}

void PostgresStore::set_sum(std::size_t chunk) {
  store_little_endian(sum_of(held_->name, chunk, held_chunk(chunk)).value(), held_->sums.data() + 4 * chunk);
}

/// Sends the sizes of the blobs of the latest put that were not written whole since.
Status PostgresStore::send_latest_sizes() {
  if (latest_.info == nullptr) return {};
  ILP_TRY(start());
  ILP_TRY(make_room());
  Status status;
  for_each_blob(*latest_.info, [&](const FieldInfo&, std::size_t blob) {
    if (latest_.sent[blob] || !status.ok()) return;
    latest_.sent[blob] = true;
    Parameters parameters;
    parameters.add(latest_.id);
    if (latest_.bytes[blob] != 0) parameters.add(std::int64_t{latest_.bytes[blob]});
    const BlobVerb verb = latest_.bytes[blob] != 0 ? BlobVerb::resize : BlobVerb::erase;
    status = send(verb, *latest_.info, blob, parameters, false);
  });
  return status;
}

Status PostgresStore::send_fill(const BlobName& blob, std::span<const std::uint8_t> sums,
                                std::span<const std::uint8_t> bytes) {
  ILP_TRY(start());
  ILP_TRY(make_room());
  Parameters parameters;
  parameters.add(blob.id).add(static_cast<std::int64_t>(blob.bytes));
  parameters.add_bytes(sums.data(), sums.size()).add_bytes(bytes.data(), bytes.size());
  return send(BlobVerb::fill, record_info(blob.type), blob.index, parameters, false);
}

Status PostgresStore::send_held_blob() {
  if (!held_->changed) return {};
  held_->changed = false;
  return send_fill(held_->name, std::span(held_->sums).first(4 * chunk_count(held_->name.bytes)),
                   std::span(held_->bytes).first(held_->name.bytes));
}

/// The blob of a record does not have the size that the record states.
Status PostgresStore::stated_size(const RecordInfo& info, const BlobName& blob, std::size_t bytes) {
  alignas(8) unsigned char record[limits::max_record_bytes];
  ILP_TRY(get(info, blob.id, record));
  std::size_t stated = 0;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    if (index == blob.index) stated = blob_bytes(record, field);
  });
  return stated == bytes ? Status{} : damaged(blob);
}

Status PostgresStore::check_range(const RecordInfo& info, const BlobName& blob, std::size_t offset, std::size_t bytes) {
  if (offset <= blob.bytes && bytes <= blob.bytes - offset) return {};
  ILP_TRY(stated_size(info, blob, blob.bytes));
  return out_of_range(Argument::blob_range, blob.bytes);
}

/// Takes the blob out of the answer.
Status PostgresStore::take_blob(BlobName& blob) {
  const Rows& rows = connection_.rows(awaited_.answer);
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
  std::memset(held_->sums.data(), 0, 4 * chunk_count(blob.bytes));
  std::copy(sums.begin(), sums.end(), held_->sums.begin());
  if (bytes.empty()) std::memset(held_->bytes.data(), 0, blob.bytes);
  std::copy(bytes.begin(), bytes.end(), held_->bytes.begin());
  held_->name = blob;
  return {};
}

Status PostgresStore::hold_blob(const RecordInfo& info, BlobName& blob) {
  if (!connected()) return StatusCode::store_lost;
  if (in_transaction_ && !doomed_.ok()) return doomed_;
  // In a transaction it has to be the newest state.
  ILP_TRY(start());
  if (in_transaction_ && awaited_.look != none) ILP_TRY(collect());
  HeldBlob* const known = find_held(blob);
  if (known != held_) ILP_TRY(send_held_blob());
  if (known != nullptr) {
    held_ = known;
    blob.bytes = known->name.bytes;
    return {};
  }
  if (in_transaction_) ILP_TRY(send_latest_sizes());
  take_place();
  ILP_TRY(make_room());
  Parameters parameters;
  parameters.add(blob.id).add(static_cast<std::int64_t>(max_postgres_blob_bytes));
  awaited_.answer = connection_.next_place();
  ILP_TRY(send(BlobVerb::read, info, blob.index, parameters, true));
  ILP_TRY(collect_answer());
  if (connection_.rows(awaited_.answer).count() == 0) {
    connection_.clear();
    ILP_TRY(stated_size(info, blob, 0));
    return {StatusCode::not_found, blob.id};
  }
  const Status status = take_blob(blob);
  connection_.clear();
  return status;
}

/// The size of a blob that was put in this transaction is known without the server.
Status PostgresStore::size_for_write(const RecordInfo& info, BlobName& blob) {
  if (latest_.info != &info || latest_.id != blob.id) return hold_blob(info, blob);
  blob.bytes = latest_.bytes[blob.index];
  return blob.bytes != 0 ? Status{} : Status{StatusCode::not_found, blob.id};
}

Status PostgresStore::write_whole(const BlobName& blob, std::span<const std::uint8_t> bytes) {
  if (latest_.info == &record_info(blob.type) && latest_.id == blob.id) latest_.sent[blob.index] = true;
  HeldBlob* const known = find_held(blob);
  if (known != held_) ILP_TRY(send_held_blob());
  if (known != nullptr) known->forget();
  if (blob.bytes < least_kept_bytes) {
    std::array<std::uint8_t, 4 * chunk_count(least_kept_bytes)> sums;
    add_sums(blob, bytes, sums.data());
    return send_fill(blob, std::span(sums).first(4 * chunk_count(blob.bytes)), bytes);
  }
  take_place();
  add_sums(blob, bytes, held_->sums.data());
  std::copy(bytes.begin(), bytes.end(), held_->bytes.begin());
  held_->name = blob;
  return send_fill(blob, std::span(held_->sums).first(4 * chunk_count(blob.bytes)), bytes);
}

/// The rest of a partly written chunk must have its checksum.
Status PostgresStore::write_part(std::size_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const std::size_t end = offset + bytes.size();
  const std::size_t last = (end - 1) / blob_chunk_bytes;
  for (std::size_t chunk = offset / blob_chunk_bytes; chunk <= last; ++chunk) {
    const std::size_t begin = chunk * blob_chunk_bytes;
    const bool whole = offset <= begin && end >= begin + held_chunk(chunk).size();
    if (!whole && !chunk_is_sound(chunk)) return damaged(held_->name);
  }
  std::copy(bytes.begin(), bytes.end(), held_->bytes.begin() + static_cast<std::ptrdiff_t>(offset));
  for (std::size_t chunk = offset / blob_chunk_bytes; chunk <= last; ++chunk) set_sum(chunk);
  held_->changed = true;
  return {};
}

Status PostgresStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                 std::span<const std::uint8_t> bytes) {
  ILP_TRY(writable());
  BlobName blob{info.type, find_blob(info, field), id, 0};
  if (blob.index == max_blob_fields) return out_of_range(Argument::blob_field);
  Status status = size_for_write(info, blob);
  if (status.ok()) status = check_range(info, blob, offset, bytes.size());
  if (status.is(StatusCode::invalid_argument) || status.is(StatusCode::not_found)) return status;
  if (status.ok() && bytes.size() == blob.bytes) return written(info, write_whole(blob, bytes));
  if (status.ok()) status = hold_blob(info, blob);
  if (status.ok()) status = write_part(offset, bytes);
  return written(info, status);
}

Status PostgresStore::read_part(std::size_t offset, std::span<std::uint8_t> bytes) const {
  if (bytes.empty()) return {};
  const std::size_t last = (offset + bytes.size() - 1) / blob_chunk_bytes;
  for (std::size_t chunk = offset / blob_chunk_bytes; chunk <= last; ++chunk) {
    if (!chunk_is_sound(chunk)) return damaged(held_->name);
  }
  std::copy_n(held_->bytes.begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
  return {};
}

Status PostgresStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                std::span<std::uint8_t> bytes) {
  BlobName blob{info.type, find_blob(info, field), id, 0};
  if (blob.index == max_blob_fields) return out_of_range(Argument::blob_field);
  const HeldBlob* const known = find_held(blob);
  const bool was_held = known != nullptr && !known->changed;
  ILP_TRY(hold_blob(info, blob));
  ILP_TRY(check_range(info, blob, offset, bytes.size()));
  Status status = read_part(offset, bytes);
  if (status.is(StatusCode::record_damaged) && was_held) {
    // A bit may have flipped here and not in the store.
    held_->name = {};
    ILP_TRY(hold_blob(info, blob));
    status = read_part(offset, bytes);
  }
  if (!status.ok()) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  return status;
}

}  // namespace ilp
