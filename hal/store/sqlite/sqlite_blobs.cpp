// Reads and writes parts of blobs in the store on a disk, with a checksum for every chunk.
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/little_endian.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/sql_columns.hpp"
#include "hal/store/sqlite/session.hpp"
#include "hal/store/sqlite/sql_text.hpp"

namespace ilp::sqlite {
namespace {

/// An open blob and its checksums.
struct BlobHandles {
  BlobName name;
  FixedText<96> table;
  sqlite3_blob* data = nullptr;
  sqlite3_blob* sums = nullptr;

  BlobHandles() = default;
  BlobHandles(const BlobHandles&) = delete;
  BlobHandles& operator=(const BlobHandles&) = delete;
  ~BlobHandles() { static_cast<void>(close()); }
  int close() {
    const int code = sqlite3_blob_close(data);
    const int also = sqlite3_blob_close(sums);
    data = nullptr;
    sums = nullptr;
    return code != SQLITE_OK ? code : also;
  }
};

using Chunk = std::array<std::uint8_t, blob_chunk_bytes>;

std::size_t size_of(const BlobHandles& blob) {
  return static_cast<std::size_t>(sqlite3_blob_bytes(blob.data));
}

int read_chunk(sqlite3_blob* blob, std::size_t offset, std::span<std::uint8_t> bytes) {
  if (bytes.empty()) return SQLITE_OK;
  return sqlite3_blob_read(blob, bytes.data(), static_cast<int>(bytes.size()), static_cast<int>(offset));
}

/// The chunk and its part in [offset, offset + bytes).
struct Part {
  std::size_t begin, end;       ///< of the chunk, in the blob
  std::size_t inside, outside;  ///< the range's begin and end in the chunk, in the blob

  Part(std::size_t chunk, std::size_t blob_bytes, std::size_t offset, std::size_t bytes)
      : begin(chunk * blob_chunk_bytes),
        end(std::min(begin + blob_chunk_bytes, blob_bytes)),
        inside(std::max(begin, offset)),
        outside(std::min(end, offset + bytes)) {}
  [[nodiscard]] bool whole() const { return inside == begin && outside == end; }
};

/// Reads the checksums of a blob in order, some at a time.
class SumReader {
 public:
  SumReader(const BlobHandles& blob, std::size_t chunk) : blob_(blob), next_(chunk) {}

  int next(std::uint32_t& sum) {
    if (at_ == held_) {
      held_ = std::min(batch, chunk_count(size_of(blob_)) - next_);
      at_ = 0;
      const int code = read_chunk(blob_.sums, next_ * 4, std::span(bytes_).first(held_ * 4));
      if (code != SQLITE_OK) return code;
    }
    sum = load_little_endian<std::uint32_t>(bytes_.data() + 4 * at_++);
    ++next_;
    return SQLITE_OK;
  }

 private:
  static constexpr std::size_t batch = 128;
  const BlobHandles& blob_;
  std::size_t next_;
  std::size_t held_ = 0, at_ = 0;
  std::array<std::uint8_t, 4 * batch> bytes_{};
};

Status not_its_checksum(const BlobHandles& blob) {
  return {StatusCode::record_damaged, blob.name.id, static_cast<std::int64_t>(blob.name.type)};
}

Status open_column(Session& s, const BlobHandles& blob, const char* column, bool writable, sqlite3_blob*& handle) {
  const int code =
      sqlite3_blob_open(s.database, "main", blob.table.c_str(), column, blob.name.id, writable ? 1 : 0, &handle);
  if (code == SQLITE_OK) return {};
  const Status status = fault(s, code);
  sqlite3_blob_close(handle);
  handle = nullptr;
  // SQLite answers a missing row, and a value that is no blob, with its general error.
  return code == SQLITE_ERROR ? Status{StatusCode::not_found, blob.name.id} : status;
}

/// The blob of a record does not have the size that the record states.
Status missing_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t bytes) {
  alignas(8) unsigned char record[limits::max_record_bytes];
  ILP_TRY(get(s, info, id, record));
  std::size_t stated = 0;
  for_each_blob(info, [&](const FieldInfo& candidate, std::size_t) {
    if (std::strcmp(candidate.name, field) == 0) stated = blob_bytes(record, candidate);
  });
  return stated == bytes ? Status{} : Status{StatusCode::record_damaged, id, static_cast<std::int64_t>(info.type)};
}

Status open_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, bool writable,
                 BlobHandles& blob) {
  if (s.database == nullptr) return out_of_range(Argument::database);
  blob.name = {info.type, find_blob(info, field), id, 0};
  if (blob.name.index == max_blob_fields) return out_of_range(Argument::blob_field);
  blob_table_name(info, field, blob.table);
  const Status opened = open_column(s, blob, "data", writable, blob.data);
  if (opened.is(StatusCode::not_found)) {
    ILP_TRY(missing_blob(s, info, field, id, 0));
    return opened;
  }
  ILP_TRY(opened);
  blob.name.bytes = size_of(blob);
  const Status with_sums = open_column(s, blob, "checksums", writable, blob.sums);
  const bool missing = with_sums.is(StatusCode::not_found);
  if (!with_sums.ok() && !missing) return with_sums;
  const auto sums = missing ? 0 : static_cast<std::size_t>(sqlite3_blob_bytes(blob.sums));
  return sums == 4 * chunk_count(blob.name.bytes) ? Status{} : not_its_checksum(blob);
}

Status check_range(Session& s, const RecordInfo& info, const char* field, const BlobHandles& blob, std::size_t offset,
                   std::size_t bytes) {
  const std::size_t size = blob.name.bytes;
  if (offset <= size && bytes <= size - offset) return {};
  ILP_TRY(missing_blob(s, info, field, blob.name.id, size));
  return out_of_range(Argument::blob_range, size);
}

/// Checks the chunks to which `bytes`, read at `offset`, belong.
Status check_chunks(Session& s, const BlobHandles& blob, std::size_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const std::size_t first = offset / blob_chunk_bytes;
  const std::size_t last = (offset + bytes.size() - 1) / blob_chunk_bytes;
  SumReader sums(blob, first);
  Chunk rest;
  for (std::size_t chunk = first; chunk <= last; ++chunk) {
    const Part part(chunk, blob.name.bytes, offset, bytes.size());
    const auto prefix = std::span(rest).first(part.inside - part.begin);
    const auto suffix = std::span(rest).subspan(prefix.size()).first(part.end - part.outside);
    std::uint32_t stored = 0;
    int code = sums.next(stored);
    if (code == SQLITE_OK) code = read_chunk(blob.data, part.begin, prefix);
    if (code == SQLITE_OK) code = read_chunk(blob.data, part.outside, suffix);
    if (code != SQLITE_OK) return fault(s, code);
    ChunkSum sum(blob.name, chunk);
    sum.add(prefix);
    sum.add(bytes.subspan(part.inside - offset, part.outside - part.inside));
    sum.add(suffix);
    if (!sum.matches(stored)) return not_its_checksum(blob);
  }
  return {};
}

/// Writes the bytes and the checksums of their chunks. The rest of a partly written chunk must have its checksum.
Status write_chunks(Session& s, const BlobHandles& blob, std::size_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const std::size_t first = offset / blob_chunk_bytes;
  const std::size_t last = (offset + bytes.size() - 1) / blob_chunk_bytes;
  Chunk rest;
  for (std::size_t chunk = first; chunk <= last; ++chunk) {
    const Part part(chunk, blob.name.bytes, offset, bytes.size());
    const auto fresh = bytes.subspan(part.inside - offset, part.outside - part.inside);
    ChunkSum sum(blob.name, chunk);
    if (part.whole()) {
      sum.add(fresh);
    } else {
      const auto old = std::span(rest).first(part.end - part.begin);
      const int code = read_chunk(blob.data, part.begin, old);
      if (code != SQLITE_OK) return fault(s, code);
      ILP_TRY(check_chunks(s, blob, part.begin, old));
      std::copy(fresh.begin(), fresh.end(), old.begin() + static_cast<std::ptrdiff_t>(part.inside - part.begin));
      sum.add(old);
    }
    std::uint8_t value[4];
    store_little_endian(sum.value(), value);
    const int code = sqlite3_blob_write(blob.sums, value, sizeof(value), static_cast<int>(4 * chunk));
    if (code != SQLITE_OK) return fault(s, code);
  }
  const int code =
      sqlite3_blob_write(blob.data, bytes.data(), static_cast<int>(bytes.size()), static_cast<int>(offset));
  return code == SQLITE_OK ? Status{} : fault(s, code);
}

}  // namespace

Status write_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                  std::span<const std::uint8_t> bytes) {
  ILP_TRY(writable(s));
  BlobHandles blob;
  Status status = open_blob(s, info, field, id, true, blob);
  if (status.ok()) status = check_range(s, info, field, blob, offset, bytes.size());
  if (status.is(StatusCode::invalid_argument) || status.is(StatusCode::not_found)) return status;
  if (status.ok()) status = write_chunks(s, blob, offset, bytes);
  const int closed = blob.close();
  if (status.ok() && closed != SQLITE_OK) status = fault(s, closed);
  return written(s, info, status);
}

Status read_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                 std::span<std::uint8_t> bytes) {
  BlobHandles blob;
  ILP_TRY(open_blob(s, info, field, id, false, blob));
  ILP_TRY(check_range(s, info, field, blob, offset, bytes.size()));
  const int code = read_chunk(blob.data, offset, bytes);
  const Status status = code == SQLITE_OK ? check_chunks(s, blob, offset, bytes) : fault(s, code);
  if (!status.ok()) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  return status;
}

Status mark_chunk_damaged(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset) {
  ILP_TRY(writable(s));
  BlobHandles blob;
  Status status = open_blob(s, info, field, id, true, blob);
  if (status.ok()) status = check_range(s, info, field, blob, offset, 1);
  if (!status.ok()) return written(s, info, status);
  const std::size_t chunk = offset / blob_chunk_bytes;
  const Part part(chunk, blob.name.bytes, offset, 1);
  Chunk content;
  const auto bytes = std::span(content).first(part.end - part.begin);
  int code = read_chunk(blob.data, part.begin, bytes);
  ChunkSum sum(blob.name, chunk);
  sum.add(bytes);
  std::uint8_t other[4];
  store_little_endian(sum.value() != 1 ? sum.value() ^ 1U : 2U, other);
  if (code == SQLITE_OK) code = sqlite3_blob_write(blob.sums, other, sizeof(other), static_cast<int>(4 * chunk));
  const int closed = blob.close();
  if (code == SQLITE_OK) code = closed;
  return written(s, info, code == SQLITE_OK ? Status{} : fault(s, code));
}

}  // namespace ilp::sqlite
