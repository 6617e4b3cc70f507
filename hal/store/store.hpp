// Interface of the onboard database: transactions, records of every table and their blobs, and which tables changed.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// A blob has one checksum for each chunk of this size; its last chunk may be shorter.
inline constexpr std::size_t blob_chunk_bytes = 4096;

struct StoreUsage {
  std::int64_t bytes = 0;        ///< on disk, or in memory
  std::int64_t free_bytes = 0;   ///< part of `bytes` that the next writes reuse
  std::int64_t limit_bytes = 0;  ///< limit that `bytes` never exceeds; 0: no known limit
};

/// Transactions of a store, without access to its tables.
class Transactions {
 public:
  Transactions() = default;
  Transactions(const Transactions&) = delete;
  Transactions& operator=(const Transactions&) = delete;

  virtual Status begin() = 0;
  /// A failed commit rolls the transaction back.
  virtual Status commit() = 0;
  virtual void rollback() = 0;

 protected:
  ~Transactions() = default;
};

/// Every call uses a bounded amount of memory. Every fault is returned as a Status and leaves stored data intact.
/// Writes outside a transaction return `invalid_argument`. After a failed write, further writes and the commit of the
/// transaction return the same Status; a write that returns `not_found` or `invalid_argument` leaves the transaction
/// usable. Values are read as they were put, with three exceptions: a NaN may become another NaN, -0 may become 0, and
/// a text ends at its terminator.
///
/// Records and blobs have checksums, which every read verifies. Reading data with a wrong checksum returns
/// `record_damaged` (first value: id, second: RecordType), never the data and never `not_found`. The damage ends when
/// the record is put again or erased. `store_damaged` reports damage to the store's own structure.
class Store : public Transactions {
 public:
  /// Inserts the record, or replaces every field of the record with the same id. A blob whose size in the record is
  /// unchanged keeps its bytes. A blob of another size gets that size and consists of zeros; size 0 means no blob.
  virtual Status put(const RecordInfo& info, const void* record) = 0;
  /// Reads the record with this id. Returns `not_found` if there is none. get(), next() and last() write `record` only
  /// when they return ok.
  virtual Status get(const RecordInfo& info, std::int64_t id, void* record) = 0;
  /// Reads the record with the smallest id above `after`. Returns `not_found` if there is none. If it returns
  /// `record_damaged`, the id in the status is above `after`, and a loop over the table can continue after that id.
  virtual Status next(const RecordInfo& info, std::int64_t after, void* record) = 0;
  /// Reads the record with the largest id. Returns `not_found` if the table is empty.
  virtual Status last(const RecordInfo& info, void* record) = 0;
  /// Erases the record with this id and its blobs. Returns `not_found` if there is none.
  virtual Status erase(const RecordInfo& info, std::int64_t id) = 0;
  virtual Status count(const RecordInfo& info, std::int64_t& records) = 0;

  /// Writes or reads bytes of a blob from `offset` on. `field` is the name of the record's blob member. Returns
  /// `not_found` if there is no such record or its blob is empty, `invalid_argument` if the bytes do not lie inside the
  /// blob. Damage in one chunk (blob_chunk_bytes) does not affect the others. Writing a part of a damaged chunk returns
  /// `record_damaged`; writing the complete chunk repairs it. If read_blob() returns `record_damaged`, `bytes` holds
  /// nothing of the blob.
  virtual Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                            std::span<const std::uint8_t> bytes) = 0;
  virtual Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                           std::span<std::uint8_t> bytes) = 0;

  /// Sets `changed` to the tables that commits of this or another process have changed since the previous call. The
  /// call is cheap.
  virtual Status poll(RecordMask& changed) = 0;
  virtual StoreUsage usage() = 0;

  /// Sets the numbers after which the ids of this store epoch begin: `keyframe_base` for tables that are numbered by
  /// keyframe, `record_base` for the others. Both are 0 in the first store epoch of a flight (IdentityRecord). The call
  /// writes nothing to the database.
  virtual void number_from(std::int64_t keyframe_base, std::int64_t record_base) {
    keyframe_base_ = keyframe_base;
    record_base_ = record_base;
  }
  /// The number after which ids of this table begin.
  [[nodiscard]] virtual std::int64_t id_base(RecordType type) const {
    return record_info(type).numbering == Numbering::by_keyframe ? keyframe_base_ : record_base_;
  }

 protected:
  ~Store() = default;

 private:
  std::int64_t keyframe_base_ = 0, record_base_ = 0;
};

template <typename Record>
Status put(Store& store, const Record& record) {
  return store.put(record_info<Record>(), &record);
}
template <typename Record>
Status get(Store& store, std::int64_t id, Record& record) {
  return store.get(record_info<Record>(), id, &record);
}
template <typename Record>
Status next(Store& store, std::int64_t after, Record& record) {
  return store.next(record_info<Record>(), after, &record);
}
template <typename Record>
Status last(Store& store, Record& record) {
  return store.last(record_info<Record>(), &record);
}
template <typename Record>
Status write_blob(Store& store, const char* field, std::int64_t id, std::size_t offset,
                  std::span<const std::uint8_t> bytes) {
  return store.write_blob(record_info<Record>(), field, id, offset, bytes);
}
template <typename Record>
Status read_blob(Store& store, const char* field, std::int64_t id, std::size_t offset, std::span<std::uint8_t> bytes) {
  return store.read_blob(record_info<Record>(), field, id, offset, bytes);
}

/// Guards a transaction: rolls it back at the end of the scope unless commit() was called.
class Transaction {
 public:
  explicit Transaction(Transactions& store) : store_(store) {}
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  ~Transaction() {
    if (open_) store_.rollback();
  }
  Status begin() {
    const Status status = store_.begin();
    open_ = status.ok();
    return status;
  }
  Status commit() {
    open_ = false;
    return store_.commit();
  }

 private:
  Transactions& store_;
  bool open_ = false;
};

}  // namespace ilp
