// Memory copy: a file on the disk with all records of a flight in memory. The next start takes them into the database.
//
// The file has a head, all records (type, fields as in fsw/records/serial.hpp, bytes of the blobs), and a tail. The
// tail has the number of records, the number of lost records and the CRC-32C of everything before the CRC. The file is
// synchronised before it gets its final name, so that a file with this name is complete.
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Callbacks during long work on a disk, in which the watchdog is kicked. Both return soon.
class DiskWait {
 public:
  /// Waits before the next attempt. The disk has failed `attempts` times, the latest time with `fault`.
  virtual void until_next_attempt(int attempts, const Status& fault) = 0;
  /// Called at least once per MiB while records are moved.
  virtual void at_work() = 0;

 protected:
  ~DiskWait() = default;
};

/// Limit of memory copies that wait for the database to be opened.
inline constexpr std::int64_t max_memory_copies = 4;

using MemoryCopyPath = FixedText<limits::max_path_bytes>;
/// Returns the path `NAME.from-memory-N` beside the database at `path`; N counts from 1.
[[nodiscard]] MemoryCopyPath memory_copy_path(const char* path, std::int64_t number);
/// Number of memory copies beside the database.
[[nodiscard]] std::int64_t count_memory_copies(const char* path);

/// Tests whether the disk works. Reads the database at `path` and its log completely, if they exist. Then writes and
/// synchronises a file of `free_bytes` beside the database, which stays reserved for write_memory_copy(). Returns
/// `io_error` (first value: errno) if the disk fails or has less free space; nothing stays reserved then. The time is
/// not bounded.
Status try_disk(const char* path, std::int64_t free_bytes);

/// Removes the reserved file, or a copy that a power cut has left incomplete. Returns `io_error` (first value: errno)
/// if that fails.
Status remove_unfinished_copy(const char* path);

/// Renames a copy that cannot be used to `COPY.refused`. If this name exists, takes `COPY.refused-2`, `-3` or `-4`; the
/// last one is replaced if all exist. Returns `io_error` (first value: errno) if that fails.
Status refuse_copy(const char* copy);

struct MemoryCopyCounts {
  std::int64_t records = 0;  ///< records in the copy
  std::int64_t lost = 0;     ///< records that were damaged in memory and are not in the copy
};

/// Writes all records of `store` into the next memory copy beside the database at `path`. `wait` may be null. Returns
/// `io_error` (first value: errno) if that fails, and `capacity_exceeded` if max_memory_copies exist already; no copy
/// is made then.
Status write_memory_copy(Store& store, const char* path, DiskWait* wait, MemoryCopyCounts& counts);

/// Reads a memory copy.
class MemoryCopy {
 public:
  MemoryCopy() = default;
  ~MemoryCopy() { close(); }
  MemoryCopy(const MemoryCopy&) = delete;
  MemoryCopy& operator=(const MemoryCopy&) = delete;

  /// Opens the file and verifies its checksum. Returns `record_damaged` if the checksum or the format is wrong,
  /// `store_build` if another build has written it, `io_error` (first value: errno) if it cannot be read.
  Status open(const char* file, DiskWait* wait);
  void close();
  /// Reads the next record into `record`, which has limits::max_record_bytes. After open() and rewind() that is the
  /// first record. Returns `not_found` at the end.
  Status next(const RecordInfo*& info, void* record);
  void rewind();
  /// Reads bytes of the blob field `index` (from 0) of the latest record from `offset` on.
  Status read_blob(std::size_t index, std::size_t offset, std::span<std::uint8_t> bytes);
  /// MemoryCopyCounts::lost of the copy.
  [[nodiscard]] std::int64_t lost() const { return lost_; }

 private:
  Status read(std::int64_t at, std::span<std::uint8_t> bytes) const;

  int file_ = -1;
  std::int64_t end_ = 0;   ///< offset in the file at which the records end
  std::int64_t next_ = 0;  ///< offset of the next record
  std::int64_t lost_ = 0;
  std::int64_t blobs_[limits::max_blob_fields] = {};  ///< offsets of the latest record's blobs
};

}  // namespace ilp
