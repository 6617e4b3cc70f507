// A store in a fixed region of memory, for tests and for flights without a disk.
#pragma once

#include <array>
#include <cstddef>

#include "fsw/base/arena.hpp"
#include "fsw/base/result.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/store.hpp"

namespace ilp {
namespace ram {

struct BlobBlock;
struct Version;
struct Undo;
/// A row of a table's index. Its checksum lets a search detect damage.
struct Row {
  std::int64_t id;
  std::uint32_t place;  ///< offset of the record's version in the region, bytes
  std::uint32_t check;  ///< CRC-32C of the other members
};
struct Table {
  Row* rows = nullptr;  ///< sorted by ascending id
  std::size_t size = 0;
  std::size_t capacity = 0;
};
struct Place {
  std::size_t position = 0;    ///< index in Table::rows of the id, or where the id would be inserted
  Version* version = nullptr;  ///< nullptr: there is no record with the id
};
struct BlobPlace {
  std::size_t index = 0;  ///< index among the blob fields of the record
  BlobBlock* block = nullptr;
};

}  // namespace ram

/// A transaction never overwrites committed data. The first write to a record makes a new version, and the old version
/// is kept until the transaction ends. A rollback therefore allocates nothing and cannot fail, and a commit only
/// releases memory. Returns `store_full` if the region has no memory left for a write. A single flipped bit in the
/// index of a table is corrected. If more of the index is damaged, every call for that table returns `store_damaged`.
class RamStore final : public Store {
 public:
  /// `region` outlives the store.
  explicit RamStore(std::span<std::byte> region);

  Status begin() override;
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status get(const RecordInfo& info, std::int64_t id, void* record) override;
  Status next(const RecordInfo& info, std::int64_t after, void* record) override;
  Status last(const RecordInfo& info, void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status count(const RecordInfo& info, std::int64_t& records) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override;
  Status poll(RecordMask& changed) override;
  StoreUsage usage() override;

  [[nodiscard]] const ArenaStats& memory() const { return arena_.stats(); }

 private:
  ram::Table& table_of(const RecordInfo& info) { return tables_[static_cast<std::size_t>(info.type)]; }
  /// Finds the position of an id in the index, and its version. Returns `store_damaged` if the index is damaged.
  [[nodiscard]] Result<ram::Place> find(const ram::Table& table, std::int64_t id) const;

  /// Returns `invalid_argument` outside a transaction, and the fault of an earlier write of the transaction.
  Status writable() const;
  /// Makes the transaction fail with this status.
  Status doom(Status status);
  Status write_record(const RecordInfo& info, const void* record);
  Result<ram::Version*> make_version(const RecordInfo& info, const void* record, ram::Version* before);
  Result<ram::BlobBlock*> make_blob(std::size_t bytes);
  Status make_undo(const RecordInfo& info, std::int64_t id, ram::Version* before);
  Result<ram::BlobPlace> find_blob_block(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                         std::size_t bytes);
  /// Returns the block if this transaction has made it, else a new copy, which the transaction may write.
  Result<ram::BlobBlock*> own_blob(const RecordInfo& info, std::int64_t id, const ram::BlobPlace& place);

  std::byte* region_;
  Arena arena_;
  std::array<ram::Table, static_cast<std::size_t>(RecordType::count)> tables_{};
  ram::Undo* undo_ = nullptr;
  std::uint64_t transaction_ = 0;
  bool in_transaction_ = false;
  Status doomed_;  ///< fault of the first failed write of the transaction
  RecordMask uncommitted_ = 0;
  RecordMask changed_ = 0;
};

}  // namespace ilp
