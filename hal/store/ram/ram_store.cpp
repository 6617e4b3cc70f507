#include "hal/store/ram/ram_store.hpp"

#include <algorithm>
#include <limits>
#include <new>

namespace ilp {

struct RamStore::BlobBlock {
  std::uint64_t stamp;  ///< transaction that allocated it: only this one may write into it
  std::size_t bytes;

  [[nodiscard]] std::uint8_t* data() { return reinterpret_cast<std::uint8_t*>(this + 1); }
};

/// One state of a record; its bytes follow.
struct RamStore::Version {
  std::int64_t id;
  std::uint64_t stamp;  ///< transaction that made it
  BlobBlock* blobs[max_blob_fields];

  [[nodiscard]] std::uint8_t* record() { return reinterpret_cast<std::uint8_t*>(this + 1); }
};

/// What stood at this id before the transaction touched it, nullptr for nothing.
struct RamStore::Undo {
  Undo* next;
  const RecordInfo* info;
  std::int64_t id;
  Version* before;
};

namespace {

/// A text ends at its first terminator, or at its capacity less one, as if it had been through a database.
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

}  // namespace

RamStore::RamStore(std::span<std::byte> region) {
  arena_.init(region.data(), region.size());
}

std::size_t RamStore::position_of(const Table& table, std::int64_t id) {
  std::size_t begin = 0;
  std::size_t end = table.size;
  while (begin < end) {
    const std::size_t middle = begin + (end - begin) / 2;
    if (table.rows[middle]->id < id) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

RamStore::Version* RamStore::find(const Table& table, std::int64_t id) {
  const std::size_t position = position_of(table, id);
  return position < table.size && table.rows[position]->id == id ? table.rows[position] : nullptr;
}

void RamStore::remove_at(Table& table, std::size_t position) {
  std::copy(table.rows + position + 1, table.rows + table.size, table.rows + position);
  --table.size;
}

void RamStore::insert_at(Table& table, std::size_t position, Version* version) {
  std::copy_backward(table.rows + position, table.rows + table.size, table.rows + table.size + 1);
  table.rows[position] = version;
  ++table.size;
}

Status RamStore::begin() {
  if (in_transaction_) return {StatusCode::invalid_argument, 1};
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
  while (undo_ != nullptr) {
    Undo* const undo = undo_;
    undo_ = undo->next;
    if (undo->before != nullptr) release_version(undo->before, find(table_of(*undo->info), undo->id), 0);
    arena_.release(undo);
  }
  in_transaction_ = false;
  changed_ |= uncommitted_;
  return {};
}

void RamStore::rollback() {
  // Latest first: a record that was erased and written again stands in the list twice.
  while (undo_ != nullptr) {
    Undo* const undo = undo_;
    undo_ = undo->next;
    Table& table = table_of(*undo->info);
    const std::size_t position = position_of(table, undo->id);
    if (position < table.size && table.rows[position]->id == undo->id) {
      release_version(table.rows[position], nullptr, transaction_);
      remove_at(table, position);
    }
    if (undo->before != nullptr) insert_at(table, position, undo->before);
    arena_.release(undo);
  }
  in_transaction_ = false;
}

Status RamStore::writable() const {
  return in_transaction_ ? doomed_ : Status{StatusCode::invalid_argument, 1};
}

Status RamStore::doom(Status status) {
  doomed_ = status;
  return status;
}

Status RamStore::full() const {
  return {StatusCode::store_full, static_cast<std::int64_t>(arena_.stats().in_use),
          static_cast<std::int64_t>(arena_.stats().capacity)};
}

void RamStore::release_version(Version* version, const Version* heir, std::uint64_t since) {
  for (std::size_t b = 0; b < max_blob_fields; ++b) {
    BlobBlock* const block = version->blobs[b];
    const bool inherited = heir != nullptr && heir->blobs[b] == block;
    if (block != nullptr && !inherited && block->stamp >= since) arena_.release(block);
  }
  arena_.release(version);
}

Status RamStore::reserve(Table& table) {
  if (table.size < table.capacity) return {};
  const std::size_t capacity = table.capacity == 0 ? 16 : 2 * table.capacity;
  void* rows = arena_.reallocate(table.rows, capacity * sizeof(void*));
  if (rows == nullptr) return full();
  table.rows = static_cast<Version**>(rows);
  table.capacity = capacity;
  return {};
}

Status RamStore::make_version(const RecordInfo& info, const void* record, const Version* before, Version*& version) {
  void* const place = arena_.allocate(sizeof(Version) + info.bytes);
  if (place == nullptr) return full();
  version = new (place) Version{id_of(record), transaction_, {}};
  std::memcpy(version->record(), record, info.bytes);
  end_texts(info, version->record());
  bool complete = true;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    const std::size_t bytes = blob_bytes(record, field);
    BlobBlock*& block = version->blobs[index];
    BlobBlock* const old = before != nullptr ? before->blobs[index] : nullptr;
    if (bytes == 0) return;
    if (old != nullptr && old->bytes == bytes) {
      block = old;
      return;
    }
    void* const room = arena_.allocate(sizeof(BlobBlock) + bytes);
    if (room == nullptr) {
      complete = false;
      return;
    }
    block = new (room) BlobBlock{transaction_, bytes};
    std::memset(block->data(), 0, bytes);
  });
  if (complete) return {};
  release_version(version, before, transaction_);
  version = nullptr;
  return full();
}

Status RamStore::make_undo(const RecordInfo& info, std::int64_t id, Version* before) {
  void* const place = arena_.allocate(sizeof(Undo));
  if (place == nullptr) return full();
  undo_ = new (place) Undo{undo_, &info, id, before};
  return {};
}

Status RamStore::write_record(const RecordInfo& info, const void* record) {
  Table& table = table_of(info);
  const std::int64_t id = id_of(record);
  const std::size_t position = position_of(table, id);
  Version* const before = find(table, id);
  Version* version = nullptr;
  if (before == nullptr) ILP_TRY(reserve(table));
  ILP_TRY(make_version(info, record, before, version));
  const bool first_touch = before == nullptr || before->stamp != transaction_;
  if (first_touch) {
    const Status status = make_undo(info, id, before);
    if (!status.ok()) {
      release_version(version, before, transaction_);
      return status;
    }
  }
  if (before == nullptr) {
    insert_at(table, position, version);
  } else {
    table.rows[position] = version;
    if (!first_touch) release_version(before, version, transaction_);
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
  Version* const version = find(table, id);
  if (version == nullptr) return {StatusCode::not_found, id};
  if (version->stamp != transaction_) {
    const Status status = make_undo(info, id, version);
    if (!status.ok()) return doom(status);
  }
  remove_at(table, position_of(table, id));
  if (version->stamp == transaction_) release_version(version, nullptr, transaction_);
  uncommitted_ |= mask_of(info.type);
  return {};
}

Status RamStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  Version* const version = find(table_of(info), id);
  if (version == nullptr) return {StatusCode::not_found, id};
  std::memcpy(record, version->record(), info.bytes);
  return {};
}

Status RamStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  const Table& table = table_of(info);
  if (after == std::numeric_limits<std::int64_t>::max()) return StatusCode::not_found;
  const std::size_t position = position_of(table, after + 1);
  if (position == table.size) return StatusCode::not_found;
  std::memcpy(record, table.rows[position]->record(), info.bytes);
  return {};
}

Status RamStore::last(const RecordInfo& info, void* record) {
  const Table& table = table_of(info);
  if (table.size == 0) return StatusCode::not_found;
  std::memcpy(record, table.rows[table.size - 1]->record(), info.bytes);
  return {};
}

Status RamStore::count(const RecordInfo& info, std::int64_t& records) {
  records = static_cast<std::int64_t>(table_of(info).size);
  return {};
}

Status RamStore::find_blob_block(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                 std::size_t bytes, std::size_t& index, BlobBlock*& block) {
  index = find_blob(info, field);
  if (index == max_blob_fields) return {StatusCode::invalid_argument, 2};
  Version* const version = find(table_of(info), id);
  block = version != nullptr ? version->blobs[index] : nullptr;
  if (block == nullptr) return {StatusCode::not_found, id};
  if (offset > block->bytes || bytes > block->bytes - offset) {
    return {StatusCode::invalid_argument, 3, static_cast<std::int64_t>(block->bytes)};
  }
  return {};
}

Status RamStore::own_blob(const RecordInfo& info, std::int64_t id, std::size_t index, BlobBlock*& block) {
  if (block->stamp == transaction_) return {};
  Version* version = find(table_of(info), id);
  if (version->stamp != transaction_) {
    ILP_TRY(write_record(info, version->record()));
    version = find(table_of(info), id);
  }
  void* const room = arena_.allocate(sizeof(BlobBlock) + block->bytes);
  if (room == nullptr) return full();
  auto* const own = new (room) BlobBlock{transaction_, block->bytes};
  std::memcpy(own->data(), block->data(), block->bytes);
  version->blobs[index] = own;
  block = own;
  return {};
}

Status RamStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                            std::span<const std::uint8_t> bytes) {
  ILP_TRY(writable());
  std::size_t index = 0;
  BlobBlock* block = nullptr;
  ILP_TRY(find_blob_block(info, field, id, offset, bytes.size(), index, block));
  const Status status = own_blob(info, id, index, block);
  if (!status.ok()) return doom(status);
  if (!bytes.empty()) std::memcpy(block->data() + offset, bytes.data(), bytes.size());
  uncommitted_ |= mask_of(info.type);
  return {};
}

Status RamStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                           std::span<std::uint8_t> bytes) {
  std::size_t index = 0;
  BlobBlock* block = nullptr;
  ILP_TRY(find_blob_block(info, field, id, offset, bytes.size(), index, block));
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
