// The records of a flight in memory as a file on its disk. The next start takes them into the database.
//
// The file has a head, all records (type, fields as in fsw/records/serial.hpp, bytes of the blobs), and a tail with the
// number of records and the CRC-32C of everything before it. A file under its final name is whole: it is renamed after
// it was synchronised.
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// What waits for a disk. Both calls end soon: they kick the watchdog.
class DiskWait {
 public:
  /// The disk has failed `attempts` times, the latest time with `fault`; the next attempt follows when this returns.
  virtual void until_next_attempt(int attempts, const Status& fault) = 0;
  /// Records are being moved. Called at least once per MiB.
  virtual void at_work() = 0;

 protected:
  ~DiskWait() = default;
};

/// At most this many files wait for a database that can be opened.
inline constexpr std::int64_t max_memory_copies = 4;

using MemoryCopyPath = FixedText<limits::max_path_bytes>;
/// `NAME.from-memory-N` beside the database at `path`; N counts from 1.
[[nodiscard]] MemoryCopyPath memory_copy_path(const char* path, std::int64_t number);
[[nodiscard]] std::int64_t count_memory_copies(const char* path);

/// Whether the disk serves: reads the database at `path` and its log from beginning to end, if they exist, and writes
/// `free_bytes` beside it, synchronised, which stay reserved for write_memory_copy(). `io_error` (a = errno) otherwise;
/// nothing stays reserved then. A disk without so much room is not written. It may take as long as the disk takes.
Status try_disk(const char* path, std::int64_t free_bytes);

/// Removes the room that was reserved, or a file that a power cut has left unfinished. `io_error` (a = errno).
Status remove_unfinished_copy(const char* path);

/// Renames a copy that cannot be used to `COPY.refused`, or `COPY.refused-2` to `-4` if that exists; the last one is
/// replaced. `io_error` (a = errno).
Status refuse_copy(const char* copy);

struct MemoryCopyCounts {
  std::int64_t records = 0;
  std::int64_t lost = 0;  ///< damaged in memory
};

/// Writes all of `store` into the next file beside the database at `path`. `io_error` (a = errno): no such file has
/// appeared. `capacity_exceeded`: max_memory_copies wait already.
Status write_memory_copy(Store& store, const char* path, DiskWait* wait, MemoryCopyCounts& counts);

class MemoryCopy {
 public:
  MemoryCopy() = default;
  ~MemoryCopy() { close(); }
  MemoryCopy(const MemoryCopy&) = delete;
  MemoryCopy& operator=(const MemoryCopy&) = delete;

  /// Reads all of the file and compares the checksum: `record_damaged`. `store_build` for a file of another build,
  /// `io_error` (a = errno) if it cannot be read.
  Status open(const char* file, DiskWait* wait);
  void close();
  /// The next record, into `record` of limits::max_record_bytes; `not_found` at the end. Begins with the first one
  /// after open() and rewind().
  Status next(const RecordInfo*& info, void* record);
  void rewind();
  /// A piece of blob field `index` (from 0) of the record that next() has returned.
  Status read_blob(std::size_t index, std::size_t offset, std::span<std::uint8_t> bytes);
  [[nodiscard]] std::int64_t lost() const { return lost_; }

 private:
  Status read(std::int64_t at, std::span<std::uint8_t> bytes) const;

  int file_ = -1;
  std::int64_t end_ = 0;   ///< of the records
  std::int64_t next_ = 0;  ///< place of the next record
  std::int64_t lost_ = 0;
  std::int64_t blobs_[limits::max_blob_fields] = {};
};

}  // namespace ilp
