#include "hal/store/ram/ram_store.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <new>

#include "fsw/base/argument.hpp"
#include "hal/store/checksums.hpp"

namespace ilp {
namespace ram {

/// The checksums of its chunks follow, then its bytes.
struct BlobBlock {
  std::uint64_t stamp;  ///< transaction that allocated it; only this one may write into it
  std::size_t bytes;
  std::uint64_t check;  ///< of the two numbers

  [[nodiscard]] static std::size_t sum_bytes(std::size_t blob_bytes) {
    return (chunk_count(blob_bytes) * sizeof(std::uint32_t) + 7) / 8 * 8;
  }
  [[nodiscard]] static std::size_t total_bytes(std::size_t blob_bytes) {
    return sizeof(BlobBlock) + sum_bytes(blob_bytes) + blob_bytes;
  }
  [[nodiscard]] std::uint64_t right_check() const {
    return crc32c({reinterpret_cast<const std::uint8_t*>(this), offsetof(BlobBlock, check)});
  }
  [[nodiscard]] bool intact() const { return check == right_check(); }
  [[nodiscard]] std::uint32_t* sums() { return reinterpret_cast<std::uint32_t*>(this + 1); }
  [[nodiscard]] std::uint8_t* data() { return reinterpret_cast<std::uint8_t*>(this + 1) + sum_bytes(bytes); }
  [[nodiscard]] std::span<std::uint8_t> chunk(std::size_t index) {
    const std::size_t begin = index * blob_chunk_bytes;
    return {data() + begin, std::min(blob_chunk_bytes, bytes - begin)};
  }
};

/// One state of a record; its bytes follow.
struct Version {
  std::int64_t id;
  std::uint64_t stamp;  ///< transaction that made it
  BlobBlock* blobs[max_blob_fields];
  std::uint64_t check;  ///< of all the rest and the record

  [[nodiscard]] std::uint8_t* record() { return reinterpret_cast<std::uint8_t*>(this + 1); }
};

/// The version at this id before the transaction changed it; nullptr for none.
struct Undo {
  Undo* next;
  const RecordInfo* info;
  std::int64_t id;
  Version* before;
};

}  // namespace ram

using namespace ram;

namespace {

/// A text ends at its first terminator, or at its capacity minus one, as in a database.
void end_texts(const RecordInfo& info, std::uint8_t* record) {
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type != FieldType::text) continue;
    std::uint8_t* text = record + field.offset;
    std::size_t length = 0;
    while (length + 1U < field.count && text[length] != 0) ++length;
    std::memset(text + length, 0, field.count - length);
  }
}

template <typename Row>
std::uint32_t row_check(const Row& row) {
  return crc32c({reinterpret_cast<const std::uint8_t*>(&row), offsetof(Row, check)});
}

Version* version_at(const Row& row, std::byte* region) {
  return reinterpret_cast<Version*>(region + row.place);
}

Row row_for(const Version& version, const std::byte* region) {
  Row row{version.id, static_cast<std::uint32_t>(reinterpret_cast<const std::byte*>(&version) - region), 0};
  row.check = row_check(row);
  return row;
}

/// Mends a row with one flipped bit: of the rows that differ in one bit, only the right one has its check.
bool valid(Row& row) {
  if (row.check == row_check(row)) return true;
  auto* const bytes = reinterpret_cast<std::uint8_t*>(&row);
  for (std::size_t bit = 0; bit < 8 * sizeof(Row); ++bit) {
    const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
    bytes[bit / 8] ^= mask;
    if (row.check == row_check(row)) return true;
    bytes[bit / 8] ^= mask;
  }
  return false;
}

/// Position of the first row whose id is not less.
Result<std::size_t> position_of(const Table& table, std::int64_t id) {
  std::size_t begin = 0;
  std::size_t end = table.size;
  while (begin < end) {  // bound: halves of the table
    const std::size_t middle = begin + (end - begin) / 2;
    if (!valid(table.rows[middle])) {
      return Status{StatusCode::store_damaged, static_cast<std::int64_t>(middle)};
    }
    if (table.rows[middle].id < id) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

void remove_at(Table& table, std::size_t position) {
  std::copy(table.rows + position + 1, table.rows + table.size, table.rows + position);
  --table.size;
}

void insert_at(Table& table, std::size_t position, Row row) {
  std::copy_backward(table.rows + position, table.rows + table.size, table.rows + table.size + 1);
  table.rows[position] = row;
  ++table.size;
}

std::uint32_t checksum(const RecordInfo& info, Version& version) {
  const auto type = static_cast<std::uint8_t>(info.type);
  const std::uint32_t head =
      crc32c({reinterpret_cast<const std::uint8_t*>(&version), offsetof(Version, check)}, crc32c({&type, 1}));
  return crc32c({version.record(), info.bytes}, head);
}

bool intact(const RecordInfo& info, Version& version) {
  return version.check == checksum(info, version);
}

Status damaged(const RecordInfo& info, std::int64_t id) {
  return {StatusCode::record_damaged, id, static_cast<std::int64_t>(info.type)};
}

Status read(const RecordInfo& info, Version& version, std::int64_t id, void* record) {
  if (!intact(info, version) || version.id != id) return damaged(info, id);
  std::memcpy(record, version.record(), info.bytes);
  return {};
}

Status full(const Arena& arena) {
  return {StatusCode::store_full, static_cast<std::int64_t>(arena.stats().in_use),
          static_cast<std::int64_t>(arena.stats().capacity)};
}

/// Releases the version and those of its blobs that do not belong to its heir and that transactions from `since` on
/// have allocated. The blob references of a damaged version are not trusted: their memory is lost until the next
/// start.
void release_version(Arena& arena, const RecordInfo& info, Version* version, Version* heir, std::uint64_t since) {
  const bool known = intact(info, *version) && (heir == nullptr || intact(info, *heir));
  for (std::size_t b = 0; b < max_blob_fields && known; ++b) {
    BlobBlock* const block = version->blobs[b];
    const bool inherited = heir != nullptr && heir->blobs[b] == block;
    if (block != nullptr && !inherited && block->intact() && block->stamp >= since) arena.release(block);
  }
  arena.release(version);
}

Status reserve(Arena& arena, Table& table) {
  if (table.size < table.capacity) return {};
  const std::size_t capacity = table.capacity == 0 ? 16 : 2 * table.capacity;
  void* rows = arena.reallocate(table.rows, capacity * sizeof(Row));
  if (rows == nullptr) return full(arena);
  table.rows = static_cast<Row*>(rows);
  table.capacity = capacity;
  return {};
}

Status check_chunks(const BlobName& blob, BlobBlock& block, std::size_t offset, std::size_t bytes) {
  if (bytes == 0) return {};
  for (std::size_t c = offset / blob_chunk_bytes; c <= (offset + bytes - 1) / blob_chunk_bytes; ++c) {
    ChunkSum sum(blob, c);
    sum.add(block.chunk(c));
    if (!sum.matches(block.sums()[c])) {
      return {StatusCode::record_damaged, blob.id, static_cast<std::int64_t>(blob.type)};
    }
  }
  return {};
}

}  // namespace

RamStore::RamStore(std::span<std::byte> region) : region_(region.data()) {
  arena_.init(region.data(), region.size());
}

Result<Place> RamStore::find(const Table& table, std::int64_t id) const {
  ILP_TAKE(const std::size_t position, position_of(table, id));
  // The search has checked the row at which it ends.
  const bool there = position < table.size && table.rows[position].id == id;
  return Place{position, there ? version_at(table.rows[position], region_) : nullptr};
}

Status RamStore::begin() {
  if (in_transaction_) return out_of_range(Argument::transaction);
  in_transaction_ = true;
  doomed_ = {};
  uncommitted_ = 0;
  ++transaction_;
  return {};
}

Status RamStore::commit() {
  const Status possible = writable();
  if (!possible.ok()) {
    rollback();
    return possible;
  }
  while (undo_ != nullptr) {  // bound: the changes of the transaction
    Undo* const undo = undo_;
    undo_ = undo->next;
    if (undo->before != nullptr) {
      // A table that cannot be searched any more releases nothing.
      const Result<Place> heir = find(table_of(*undo->info), undo->id);
      if (heir.ok()) release_version(arena_, *undo->info, undo->before, heir.value().version, 0);
    }
    arena_.release(undo);
  }
  in_transaction_ = false;
  changed_ |= uncommitted_;
  return {};
}

void RamStore::rollback() {
  // Latest first, because a record that was erased and written again is in the list twice.
  while (undo_ != nullptr) {  // bound: the changes of the transaction
    Undo* const undo = undo_;
    undo_ = undo->next;
    Table& table = table_of(*undo->info);
    const Result<Place> found = find(table, undo->id);
    if (found.ok()) {
      const auto [position, written] = found.value();
      if (written != nullptr) {
        release_version(arena_, *undo->info, written, nullptr, transaction_);
        remove_at(table, position);
      }
      if (undo->before != nullptr) {
        Row row = row_for(*undo->before, region_);
        row.id = undo->id;
        row.check = row_check(row);
        insert_at(table, position, row);
      }
    }
    arena_.release(undo);
  }
  in_transaction_ = false;
}

Status RamStore::writable() const {
  return in_transaction_ ? doomed_ : out_of_range(Argument::transaction);
}

Status RamStore::doom(Status status) {
  doomed_ = status;
  return status;
}

Result<BlobBlock*> RamStore::make_blob(std::size_t bytes) {
  void* const memory = arena_.allocate(BlobBlock::total_bytes(bytes));
  if (memory == nullptr) return full(arena_);
  auto* const block = new (memory) BlobBlock{transaction_, bytes, 0};
  block->check = block->right_check();
  std::memset(block->sums(), 0, BlobBlock::sum_bytes(bytes) + bytes);
  return block;
}

Result<Version*> RamStore::make_version(const RecordInfo& info, const void* record, Version* before) {
  void* const place = arena_.allocate(sizeof(Version) + info.bytes);
  if (place == nullptr) return full(arena_);
  auto* const version = new (place) Version{id_of(record), transaction_, {}, 0};
  std::memcpy(version->record(), record, info.bytes);
  end_texts(info, version->record());
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    const std::size_t bytes = blob_bytes(record, field);
    BlobBlock* const old = before != nullptr ? before->blobs[index] : nullptr;
    if (bytes == 0 || !status.ok()) return;
    if (old != nullptr && old->intact() && old->bytes == bytes) {
      version->blobs[index] = old;
    } else {
      const Result<BlobBlock*> made = make_blob(bytes);
      version->blobs[index] = made.value();
      status = made.status();
    }
  });
  version->check = checksum(info, *version);
  if (status.ok()) return version;
  release_version(arena_, info, version, before, transaction_);
  return status;
}

Status RamStore::make_undo(const RecordInfo& info, std::int64_t id, Version* before) {
  void* const place = arena_.allocate(sizeof(Undo));
  if (place == nullptr) return full(arena_);
  undo_ = new (place) Undo{undo_, &info, id, before};
  return {};
}

Status RamStore::write_record(const RecordInfo& info, const void* record) {
  Table& table = table_of(info);
  const std::int64_t id = id_of(record);
  ILP_TAKE(const Place at, find(table, id));
  Version* const before = at.version;
  if (before == nullptr) ILP_TRY(reserve(arena_, table));
  // The blobs of a damaged record are unknown: the new one has its own.
  Version* const heritage = before != nullptr && intact(info, *before) ? before : nullptr;
  ILP_TAKE(Version* const version, make_version(info, record, heritage));
  const bool first_touch = before == nullptr || heritage == nullptr || before->stamp != transaction_;
  if (first_touch) {
    const Status status = make_undo(info, id, before);
    if (!status.ok()) {
      release_version(arena_, info, version, heritage, transaction_);
      return status;
    }
  }
  if (before == nullptr) {
    insert_at(table, at.position, row_for(*version, region_));
  } else {
    table.rows[at.position] = row_for(*version, region_);
    if (!first_touch) release_version(arena_, info, before, version, transaction_);
  }
  return {};
}

Status RamStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(writable());
  const Status status = write_record(info, record);
  if (!status.ok()) return doom(status);
  uncommitted_ |= mask_of(info.type);
  return {};
}

Status RamStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(writable());
  Table& table = table_of(info);
  const Result<Place> found = find(table, id);
  if (!found.ok()) return doom(found.status());
  const auto [position, version] = found.value();
  if (version == nullptr) return {StatusCode::not_found, id};
  const bool own = intact(info, *version) && version->stamp == transaction_;
  if (!own) {
    const Status status = make_undo(info, id, version);
    if (!status.ok()) return doom(status);
  }
  remove_at(table, position);
  if (own) release_version(arena_, info, version, nullptr, transaction_);
  uncommitted_ |= mask_of(info.type);
  return {};
}

Status RamStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  ILP_TAKE(const Place at, find(table_of(info), id));
  return at.version != nullptr ? read(info, *at.version, id, record) : Status{StatusCode::not_found, id};
}

Status RamStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  const Table& table = table_of(info);
  if (after == std::numeric_limits<std::int64_t>::max()) return StatusCode::not_found;
  ILP_TAKE(const std::size_t position, position_of(table, after + 1));
  if (position == table.size) return StatusCode::not_found;
  return read(info, *version_at(table.rows[position], region_), table.rows[position].id, record);
}

Status RamStore::last(const RecordInfo& info, void* record) {
  const Table& table = table_of(info);
  if (table.size == 0) return StatusCode::not_found;
  Row& row = table.rows[table.size - 1];
  if (!valid(row)) return {StatusCode::store_damaged, static_cast<std::int64_t>(table.size)};
  return read(info, *version_at(row, region_), row.id, record);
}

Status RamStore::count(const RecordInfo& info, std::int64_t& records) {
  records = static_cast<std::int64_t>(table_of(info).size);
  return {};
}

Result<BlobPlace> RamStore::find_blob_block(const RecordInfo& info, const char* field, std::int64_t id,
                                            std::size_t offset, std::size_t bytes) {
  const std::size_t index = find_blob(info, field);
  if (index == max_blob_fields) return out_of_range(Argument::blob_field);
  ILP_TAKE(const Place at, find(table_of(info), id));
  if (at.version != nullptr && !intact(info, *at.version)) return damaged(info, id);
  BlobBlock* const block = at.version != nullptr ? at.version->blobs[index] : nullptr;
  if (block == nullptr) return Status{StatusCode::not_found, id};
  if (!block->intact()) return damaged(info, id);
  if (offset > block->bytes || bytes > block->bytes - offset) {
    return out_of_range(Argument::blob_range, block->bytes);
  }
  return BlobPlace{index, block};
}

Result<BlobBlock*> RamStore::own_blob(const RecordInfo& info, std::int64_t id, const BlobPlace& place) {
  BlobBlock* const block = place.block;
  if (block->stamp == transaction_) return block;
  Table& table = table_of(info);
  ILP_TAKE(Place at, find(table, id));
  if (at.version != nullptr && at.version->stamp != transaction_) {
    ILP_TRY(write_record(info, at.version->record()));
    ILP_TAKE(at, find(table, id));
  }
  if (at.version == nullptr) return Status{StatusCode::not_found, id};
  ILP_TAKE(BlobBlock* const own, make_blob(block->bytes));
  std::memcpy(own->sums(), block->sums(), BlobBlock::sum_bytes(block->bytes) + block->bytes);
  at.version->blobs[place.index] = own;
  at.version->check = checksum(info, *at.version);
  return own;
}

Status RamStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                            std::span<const std::uint8_t> bytes) {
  ILP_TRY(writable());
  const Result<BlobPlace> found = find_blob_block(info, field, id, offset, bytes.size());
  Status status = found.status();
  if (status.is(StatusCode::invalid_argument) || status.is(StatusCode::not_found)) return status;
  const Result<BlobBlock*> own = status.ok() ? own_blob(info, id, found.value()) : status;
  if (!own.ok()) return doom(own.status());
  BlobBlock* const block = own.value();
  uncommitted_ |= mask_of(info.type);
  if (bytes.empty()) return {};
  const BlobName blob{info.type, found.value().index, id, block->bytes};
  const std::size_t end = offset + bytes.size();
  const std::size_t first = offset / blob_chunk_bytes;
  const std::size_t last = (end - 1) / blob_chunk_bytes;
  // The rest of a partly written chunk must have its checksum.
  if (offset % blob_chunk_bytes != 0) status = check_chunks(blob, *block, offset, 1);
  if (status.ok() && end % blob_chunk_bytes != 0 && end != block->bytes) status = check_chunks(blob, *block, end, 1);
  if (!status.ok()) return doom(status);
  std::memcpy(block->data() + offset, bytes.data(), bytes.size());
  for (std::size_t c = first; c <= last; ++c) {
    ChunkSum sum(blob, c);
    sum.add(block->chunk(c));
    block->sums()[c] = sum.value();
  }
  return {};
}

Status RamStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                           std::span<std::uint8_t> bytes) {
  ILP_TAKE(const auto place, find_blob_block(info, field, id, offset, bytes.size()));
  BlobBlock* const block = place.block;
  const Status status = check_chunks({info.type, place.index, id, block->bytes}, *block, offset, bytes.size());
  if (!status.ok()) {
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
    return status;
  }
  if (!bytes.empty()) std::memcpy(bytes.data(), block->data() + offset, bytes.size());
  return {};
}

Status RamStore::poll(RecordMask& changed) {
  changed = changed_;
  changed_ = 0;
  return {};
}

StoreUsage RamStore::usage() {
  return {static_cast<std::int64_t>(arena_.stats().capacity),
          static_cast<std::int64_t>(arena_.stats().capacity - arena_.stats().in_use),
          static_cast<std::int64_t>(arena_.stats().capacity)};
}

}  // namespace ilp
