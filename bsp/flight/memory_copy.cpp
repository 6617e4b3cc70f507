#include "bsp/flight/memory_copy.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>

#include "bsp/flight/flight_software.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/base/result.hpp"
#include "fsw/records/serial.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "hal/posix/file.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/sql_text.hpp"

namespace ilp {
namespace {

constexpr std::uint8_t magic[8] = {'I', 'L', 'P', 'M', 'E', 'M', '1', '\n'};
constexpr std::size_t head_bytes = sizeof(magic) + 4;
/// Records, losses, CRC-32C.
constexpr std::size_t tail_bytes = 8 + 8 + 4;
constexpr std::size_t copy_chunk_bytes = blob_chunk_bytes;
constexpr std::int64_t bytes_between_kicks = 1 << 20;
constexpr const char* reserve_suffix = ".memory-part";

Status fault(int error) {
  return {StatusCode::io_error, error};
}

MemoryCopyPath next_to(const char* path, const char* suffix) {
  MemoryCopyPath name;
  name.add(path).add(suffix);
  return name;
}

/// Of everything that gives the bytes of the file their meaning.
std::uint32_t build_fingerprint() {
  std::uint8_t number[12];
  store_little_endian(static_cast<std::uint32_t>(schema_fingerprint()), number);
  std::uint32_t crc = crc32c(std::span(number).first(4));
  for (const CheckpointForm* const form : checkpoint_forms()) {
    store_little_endian(static_cast<std::uint32_t>(form->component), number);
    store_little_endian(form->layout, number + 4);
    store_little_endian(form->bytes, number + 8);
    crc = crc32c(number, crc);
  }
  return crc;
}

/// Bytes read at once; 0 at the end, -1 with errno.
std::int64_t read_some(int file, std::int64_t at, std::span<std::uint8_t> bytes) {
  for (;;) {
    const auto got = ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (got >= 0 || errno != EINTR) return got;
  }
}

/// Whether `file` and the free blocks of its disk have so many bytes.
Status find_free_bytes(int file, std::int64_t bytes) {
  struct statvfs disk {};
  struct stat state {};
  if (::fstatvfs(file, &disk) != 0 || ::fstat(file, &state) != 0) return fault(errno);
  const auto free = static_cast<std::int64_t>(disk.f_bavail) * static_cast<std::int64_t>(disk.f_frsize);
  // st_blocks counts in units of 512 bytes.
  return free + 512 * static_cast<std::int64_t>(state.st_blocks) >= bytes ? Status{} : fault(ENOSPC);
}

/// A file that does not exist reads well.
Status read_through(const char* path) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{} : fault(errno);
  std::uint8_t chunk[2 * copy_chunk_bytes];
  std::int64_t got = 0;
  std::int64_t at = 0;
  while ((got = read_some(file, at, chunk)) > 0) at += got;
  const int error = got < 0 ? errno : 0;
  ::close(file);
  return error == 0 ? Status{} : fault(error);
}

/// The file while it is written.
class Writer {
 public:
  Writer(int file, DiskWait* wait) : file_(file), wait_(wait) {}

  Status add(std::span<const std::uint8_t> bytes) {
    crc_ = crc32c(bytes, crc_);
    ILP_TRY(write_all(file_, bytes));
    bytes_ += static_cast<std::int64_t>(bytes.size());
    if (wait_ != nullptr && bytes_ - kicked_ >= bytes_between_kicks) {
      // The last synchronisation must not take longer than the watchdog waits.
      if (::fdatasync(file_) != 0) return {StatusCode::io_error, errno};
      wait_->at_work();
      kicked_ = bytes_;
    }
    return {};
  }
  /// Takes back everything behind `mark`.
  Status return_to(std::int64_t mark, std::uint32_t crc) {
    bytes_ = mark;
    kicked_ = std::min(kicked_, mark);
    crc_ = crc;
    return ::lseek(file_, static_cast<off_t>(mark), SEEK_SET) < 0 ? fault(errno) : Status{};
  }
  [[nodiscard]] std::int64_t bytes() const { return bytes_; }
  [[nodiscard]] std::uint32_t crc() const { return crc_; }

 private:
  int file_;
  DiskWait* wait_;
  std::int64_t bytes_ = 0;
  std::int64_t kicked_ = 0;
  std::uint32_t crc_ = 0;
};

/// False if a part of the record is damaged in memory.
Result<bool> write_record(Store& store, const RecordInfo& info, const void* record, Writer& out) {
  std::uint8_t bytes[1 + limits::max_record_bytes];
  bool readable = true;
  const std::size_t size = serial_bytes(info);
  bytes[0] = static_cast<std::uint8_t>(info.type);
  ILP_TRY(serialize(info, record, std::span(bytes).subspan(1)));
  ILP_TRY(out.add(std::span(bytes).first(1 + size)));
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
    const std::size_t all = blob_bytes(record, field);
    std::uint8_t chunk[copy_chunk_bytes];
    for (std::size_t at = 0; at < all && readable && status.ok(); at += copy_chunk_bytes) {
      const auto part = std::span(chunk).first(std::min(copy_chunk_bytes, all - at));
      readable = store.read_blob(info, field.name, id_of(record), at, part).ok();
      if (readable) status = out.add(part);
    }
  });
  ILP_TRY(status);
  return readable;
}

Status write_table(Store& store, const RecordInfo& info, Writer& out, MemoryCopyCounts& counts) {
  alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
  std::int64_t after = std::numeric_limits<std::int64_t>::min();
  for (;;) {
    const Status found = store.next(info, after, record);
    if (found.is(StatusCode::not_found)) return {};
    if (!found.ok()) ++counts.lost;
    // The rest of a table whose index is damaged cannot be reached.
    if (!found.ok() && !found.is(StatusCode::record_damaged)) return {};
    after = found.ok() ? id_of(record) : found.a;
    if (!found.ok()) continue;
    const std::int64_t mark = out.bytes();
    const std::uint32_t crc = out.crc();
    ILP_TAKE(const bool readable, write_record(store, info, record, out));
    if (readable) ++counts.records;
    if (readable) continue;
    ++counts.lost;
    ILP_TRY(out.return_to(mark, crc));
  }
}

Status write_content(Store& store, int file, DiskWait* wait, MemoryCopyCounts& counts) {
  Writer out(file, wait);
  std::uint8_t head[head_bytes];
  std::memcpy(head, magic, sizeof(magic));
  store_little_endian(build_fingerprint(), head + sizeof(magic));
  ILP_TRY(out.add(head));
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    ILP_TRY(write_table(store, record_info(static_cast<RecordType>(t)), out, counts));
  }
  std::uint8_t tail[tail_bytes];
  store_little_endian(static_cast<std::uint64_t>(counts.records), tail);
  store_little_endian(static_cast<std::uint64_t>(counts.lost), tail + 8);
  store_little_endian(crc32c(std::span(tail).first(16), out.crc()), tail + 16);
  ILP_TRY(write_all(file, tail));
  const std::int64_t size = out.bytes() + static_cast<std::int64_t>(sizeof(tail));
  if (::ftruncate(file, static_cast<off_t>(size)) != 0 || ::fsync(file) != 0) return fault(errno);
  return {};
}

}  // namespace

MemoryCopyPath memory_copy_path(const char* path, std::int64_t number) {
  return next_to(path, ".from-memory-").add(number);
}

std::int64_t count_memory_copies(const char* path) {
  std::int64_t count = 0;
  for (std::int64_t n = 1; n <= max_memory_copies; ++n) {
    if (::access(memory_copy_path(path, n).c_str(), F_OK) == 0) ++count;
  }
  return count;
}

Status remove_unfinished_copy(const char* path) {
  return ::unlink(next_to(path, reserve_suffix).c_str()) == 0 || errno == ENOENT ? Status{} : fault(errno);
}

Status refuse_copy(const char* copy) {
  MemoryCopyPath to = next_to(copy, ".refused");
  for (std::int64_t number = 2; number <= max_memory_copies && ::access(to.c_str(), F_OK) == 0; ++number) {
    to = next_to(copy, ".refused-").add(number);
  }
  return std::rename(copy, to.c_str()) == 0 ? Status{} : fault(errno);
}

Status try_disk(const char* path, std::int64_t free_bytes) {
  ILP_TRY(read_through(path));
  ILP_TRY(read_through(next_to(path, "-wal").c_str()));
  const MemoryCopyPath reserve = next_to(path, reserve_suffix);
  const int file = ::open(reserve.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) return fault(errno);
  Status status = find_free_bytes(file, free_bytes);
  constexpr std::uint8_t chunk[2 * copy_chunk_bytes] = {};
  for (std::int64_t at = 0; at < free_bytes && status.ok(); at += static_cast<std::int64_t>(sizeof(chunk))) {
    status = write_all(file, chunk);
  }
  if (status.ok() && ::fsync(file) != 0) status = fault(errno);
  if (::close(file) != 0 && status.ok()) status = fault(errno);
  if (!status.ok()) ::unlink(reserve.c_str());
  return status;
}

namespace {

/// The copies that wait get the first numbers, in their order, so that the next one comes last.
Status renumber_copies(const char* path, std::int64_t& next) {
  next = 1;
  for (std::int64_t number = 1; number <= max_memory_copies; ++number) {
    const MemoryCopyPath from = memory_copy_path(path, number);
    if (::access(from.c_str(), F_OK) != 0) continue;
    const MemoryCopyPath to = memory_copy_path(path, next);
    if (number != next && std::rename(from.c_str(), to.c_str()) != 0) return fault(errno);
    ++next;
  }
  return {};
}

}  // namespace

Status write_memory_copy(Store& store, const char* path, DiskWait* wait, MemoryCopyCounts& counts) {
  counts = {};
  std::int64_t number = 1;
  ILP_TRY(renumber_copies(path, number));
  const MemoryCopyPath to = memory_copy_path(path, number);
  const MemoryCopyPath part = next_to(path, reserve_suffix);
  if (number > max_memory_copies || to.overflow()) return {StatusCode::capacity_exceeded, number, max_memory_copies};
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) return fault(errno);
  Status status = write_content(store, file, wait, counts);
  if (::close(file) != 0 && status.ok()) status = fault(errno);
  if (status.ok() && std::rename(part.c_str(), to.c_str()) != 0) status = fault(errno);
  if (status.ok()) status = synchronise_folder_of(path);
  if (!status.ok()) {
    ::unlink(part.c_str());
    ::unlink(to.c_str());
  }
  return status;
}

Status MemoryCopy::read(std::int64_t at, std::span<std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const std::int64_t got = read_some(file_, at, bytes);
    if (got <= 0) return fault(got < 0 ? errno : ENODATA);
    at += got;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return {};
}

Status MemoryCopy::open(const char* file, DiskWait* wait) {
  close();
  file_ = ::open(file, O_RDONLY | O_CLOEXEC);
  struct stat state {};
  if (file_ < 0 || ::fstat(file_, &state) != 0) return fault(errno);
  end_ = static_cast<std::int64_t>(state.st_size) - static_cast<std::int64_t>(tail_bytes);
  if (end_ < static_cast<std::int64_t>(head_bytes)) return {StatusCode::record_damaged, 0, state.st_size};
  std::uint8_t head[head_bytes];
  ILP_TRY(read(0, head));
  if (std::memcmp(head, magic, sizeof(magic)) != 0) return StatusCode::record_damaged;
  std::uint8_t chunk[copy_chunk_bytes];
  std::uint32_t crc = 0;
  // The CRC covers the tail up to itself.
  const std::int64_t covered = end_ + 16;
  for (std::int64_t at = 0; at < covered; at += static_cast<std::int64_t>(copy_chunk_bytes)) {
    const auto part = std::span(chunk).first(
        static_cast<std::size_t>(std::min(static_cast<std::int64_t>(copy_chunk_bytes), covered - at)));
    ILP_TRY(read(at, part));
    crc = crc32c(part, crc);
    if (wait != nullptr && at % bytes_between_kicks == 0) wait->at_work();
  }
  std::uint8_t tail[tail_bytes];
  ILP_TRY(read(end_, tail));
  if (load_little_endian<std::uint32_t>(tail + 16) != crc) return StatusCode::record_damaged;
  const auto build = load_little_endian<std::uint32_t>(head + sizeof(magic));
  if (build != build_fingerprint()) return {StatusCode::store_build, 0, build};
  lost_ = static_cast<std::int64_t>(load_little_endian<std::uint64_t>(tail + 8));
  rewind();
  return {};
}

void MemoryCopy::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

void MemoryCopy::rewind() {
  next_ = static_cast<std::int64_t>(head_bytes);
}

Status MemoryCopy::next(const RecordInfo*& info, void* record) {
  if (next_ >= end_) return StatusCode::not_found;
  std::uint8_t bytes[limits::max_record_bytes];
  std::uint8_t type = 0;
  ILP_TRY(read(next_, std::span(&type, 1)));
  if (type >= static_cast<std::uint8_t>(RecordType::count)) return StatusCode::record_damaged;
  info = &record_info(static_cast<RecordType>(type));
  const auto serial = std::span(bytes).first(serial_bytes(*info));
  ILP_TRY(read(next_ + 1, serial));
  ILP_TRY(deserialize(*info, serial, record));
  next_ += 1 + static_cast<std::int64_t>(serial.size());
  for_each_blob(*info, [&](const FieldInfo& field, std::size_t index) {
    blobs_[index] = next_;
    next_ += static_cast<std::int64_t>(blob_bytes(record, field));
  });
  return {};
}

Status MemoryCopy::read_blob(std::size_t index, std::size_t offset, std::span<std::uint8_t> bytes) {
  return read(blobs_[index] + static_cast<std::int64_t>(offset), bytes);
}

}  // namespace ilp
