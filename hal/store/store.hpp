// The onboard database: the data that components read and write, and the reports of changes.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

inline constexpr std::size_t blob_chunk_bytes = 4096;

struct StoreUsage {
  std::int64_t bytes = 0;        ///< on disk, or in memory
  std::int64_t free_bytes = 0;   ///< inside `bytes`, reused by the next writes
  std::int64_t limit_bytes = 0;  ///< `bytes` never exceeds it; 0: no known limit
};

/// The part of a store that a transaction uses.
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

/// All calls are bounded in memory. Every fault is a Status and leaves stored data intact. Writes outside a transaction
/// are refused with `invalid_argument`. After a failed write, further writes and the commit of its transaction return
/// the same Status. Numbers are returned as they were put, except that a NaN may become another NaN and -0 may become
/// 0; texts end at their terminator.
/// Records and blobs have checksums, which every read compares. Data with a wrong checksum is answered with
/// `record_damaged` (a = id, b = RecordType); it is not delivered, and it is never reported as `not_found`. Putting or
/// erasing the record ends this state. `store_damaged` reports that the store's own structure is damaged.
class Store : public Transactions {
 public:
  /// Inserts the record, or replaces every field of the one with the same id. A blob field keeps its bytes when its
  /// size is unchanged; otherwise it becomes that many zero bytes (0: none).
  virtual Status put(const RecordInfo& info, const void* record) = 0;
  /// `not_found` when there is none with this id. Here and below, `record` is written only when the answer is ok.
  virtual Status get(const RecordInfo& info, std::int64_t id, void* record) = 0;
  /// The record with the smallest id greater than `after`; `not_found` at the end. With `record_damaged` the walk can
  /// continue after the id that it names, which is greater than `after`.
  virtual Status next(const RecordInfo& info, std::int64_t after, void* record) = 0;
  /// The record with the largest id.
  virtual Status last(const RecordInfo& info, void* record) = 0;
  virtual Status erase(const RecordInfo& info, std::int64_t id) = 0;
  virtual Status count(const RecordInfo& info, std::int64_t& records) = 0;

  /// `field` is the blob member's name. Offset and length must lie inside the blob (`invalid_argument`). Checksums
  /// cover chunks of `blob_chunk_bytes`; damage in one does not affect the others. A part of a damaged chunk cannot be
  /// written (`record_damaged`), the whole chunk can. After `record_damaged`, `bytes` holds nothing of the blob.
  virtual Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                            std::span<const std::uint8_t> bytes) = 0;
  virtual Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                           std::span<std::uint8_t> bytes) = 0;

  /// Tables changed since the previous call, by this process (after commit) or another one. The call is cheap.
  virtual Status poll(RecordMask& changed) = 0;
  virtual StoreUsage usage() = 0;

  /// Ids begin after this number, which is 0 in the first store epoch of a flight (IdentityRecord). Nothing is stored.
  virtual void number_from(std::int64_t keyframe_base, std::int64_t record_base) {
    keyframe_base_ = keyframe_base;
    record_base_ = record_base;
  }
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

/// Rolls back at every exit from a scope except after a successful commit.
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
