// The store in a fixed region of memory: for tests, and for flights without a disk.
#pragma once

#include <array>
#include <cstddef>

#include "fsw/base/arena.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// A transaction never overwrites what was committed: the first touch of a record in it makes a new version, and the
/// old one is kept until the end. So rolling back allocates nothing and cannot fail, and committing only releases.
/// `store_full` when the region has no room for a write.
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
  struct Table {
    Version** rows = nullptr;  ///< ascending ids
    std::size_t size = 0;
    std::size_t capacity = 0;
  };

  Table& table_of(const RecordInfo& info) { return tables_[static_cast<std::size_t>(info.type)]; }
  static std::size_t position_of(const Table& table, std::int64_t id);
  static Version* find(const Table& table, std::int64_t id);
  static void remove_at(Table& table, std::size_t position);
  static void insert_at(Table& table, std::size_t position, Version* version);

  Status writable() const;
  Status doom(Status status);
  Status full() const;
  Status reserve(Table& table);
  Status write_record(const RecordInfo& info, const void* record);
  Status make_version(const RecordInfo& info, const void* record, const Version* before, Version*& version);
  Status make_undo(const RecordInfo& info, std::int64_t id, Version* before);
  Status find_blob_block(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                         std::size_t bytes, std::size_t& index, BlobBlock*& block);
  /// Makes `block` one that this transaction may write into.
  Status own_blob(const RecordInfo& info, std::int64_t id, std::size_t index, BlobBlock*& block);
  /// With those of its blobs that are not its heir's and that transactions from `since` on have allocated.
  void release_version(Version* version, const Version* heir, std::uint64_t since);

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
