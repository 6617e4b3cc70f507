// The store in a fixed region of memory: for tests, and for flights without a disk.
#pragma once

#include <array>
#include <cstddef>

#include "fsw/base/arena.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// A transaction never overwrites what was committed: the first touch of a record in it makes a new version, and the
/// old one is kept until the end. So rolling back allocates nothing and cannot fail, and committing only releases.
/// `store_full` when the region has no room for a write. A bit that flips in the index of a table is mended; where more
/// of it is broken, every call for that table answers `store_damaged`.
class RamStore final : public Store {
 public:
  /// The region outlives the store.
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
  struct BlobBlock;
  struct Version;
  struct Undo;
  /// Of the index. It can be checked, so that a search is never led astray.
  struct Row {
    std::int64_t id;
    std::uint32_t place;  ///< of the version, in the region
    std::uint32_t check;
  };
  struct Table {
    Row* rows = nullptr;  ///< ascending ids
    std::size_t size = 0;
    std::size_t capacity = 0;
  };

  Table& table_of(const RecordInfo& info) { return tables_[static_cast<std::size_t>(info.type)]; }
  Version* version_at(const Row& row);
  Row row_for(const Version& version) const;
  static bool sound(Row& row);
  /// Of the first row whose id is not less.
  static Status position_of(const Table& table, std::int64_t id, std::size_t& position);
  /// `version` is nullptr when there is none.
  Status find(const Table& table, std::int64_t id, std::size_t& position, Version*& version);
  static void remove_at(Table& table, std::size_t position);
  static void insert_at(Table& table, std::size_t position, Row row);
  static std::uint32_t checksum(const RecordInfo& info, Version& version);
  static bool intact(const RecordInfo& info, Version& version);
  static Status damaged(const RecordInfo& info, std::int64_t id);
  Status read(const RecordInfo& info, Version& version, std::int64_t id, void* record);

  Status writable() const;
  Status doom(Status status);
  Status full() const;
  Status reserve(Table& table);
  Status write_record(const RecordInfo& info, const void* record);
  Status make_version(const RecordInfo& info, const void* record, Version* before, Version*& version);
  Status make_blob(std::size_t bytes, BlobBlock*& block);
  static Status check_chunks(const BlobName& blob, BlobBlock& block, std::size_t offset, std::size_t bytes);
  Status make_undo(const RecordInfo& info, std::int64_t id, Version* before);
  Status find_blob_block(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                         std::size_t bytes, std::size_t& index, BlobBlock*& block);
  /// Makes `block` one that this transaction may write into.
  Status own_blob(const RecordInfo& info, std::int64_t id, std::size_t index, BlobBlock*& block);
  /// With those of its blobs that are not its heir's and that transactions from `since` on have allocated. What a
  /// damaged version says of its blobs is not believed: their memory is lost until the next start.
  void release_version(const RecordInfo& info, Version* version, Version* heir, std::uint64_t since);

  std::byte* region_;
  Arena arena_;
  std::array<Table, static_cast<std::size_t>(RecordType::count)> tables_{};
  Undo* undo_ = nullptr;
  std::uint64_t transaction_ = 0;
  bool in_transaction_ = false;
  Status doomed_;
  RecordMask uncommitted_ = 0;
  RecordMask changed_ = 0;
};

}  // namespace ilp
