#include "hal/store/sqlite/checked_vfs.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>
#include <span>

#include "hal/store/sqlite/disk_file.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/reserve.hpp"

namespace ilp {
namespace {

constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();

std::atomic<std::int64_t> refused{0};
std::atomic<std::int64_t> unreadable{0};
std::atomic<std::int64_t> without_capacity{0};

using Salts = std::array<std::uint8_t, 8>;

/// A database or its log; the underlying VFS's file follows.
struct CheckedFile {
  sqlite3_file base;
  const char* name;  ///< of a database
  bool is_log;
  bool checked;  ///< a database whose pages have checksums
  bool big_endian;
  // For a log. Frames count from 0.
  Salts salts;           ///< of the log that the next four are about
  std::int64_t headed;   ///< frame whose header was written last: its page follows
  bool ended;            ///< that frame ends a transaction
  std::int64_t written;  ///< frames that may be in the log, also of transactions that were rolled back
  bool unsure;           ///< a synchronisation failed: what the disk has of the log is not known
  /// From this frame on SQLite has put other pages into frames of the open transaction, and has yet to write their
  /// checksums.
  std::int64_t stale;
  LogMark mark;

  [[nodiscard]] sqlite3_file* disk() {
    return reinterpret_cast<sqlite3_file*>(reinterpret_cast<std::byte*>(this) + place_of_disk());
  }
  [[nodiscard]] static constexpr std::size_t place_of_disk() { return (sizeof(CheckedFile) + 15) / 16 * 16; }
};

CheckedFile& of(sqlite3_file* file) {
  return *reinterpret_cast<CheckedFile*>(file);
}

int size_of(CheckedFile& file, sqlite3_int64& bytes) {
  int code = SQLITE_IOERR_FSTAT;
  for (int attempt = 0; attempt < disk_attempts && code != SQLITE_OK; ++attempt) {
    code = file.disk()->pMethods->xFileSize(file.disk(), &bytes);
  }
  return code;
}

/// SQLITE_IOERR_SHORT_READ only at the end of the file. Any other fault is SQLITE_IOERR_READ: SQLite would take
/// SQLITE_IOERR_CORRUPTFS, which is what it makes of EIO, for damage.
int read_disk(CheckedFile& file, std::span<std::uint8_t> bytes, std::int64_t at) {
  sqlite3_file* const disk = file.disk();
  for (int attempt = 0; attempt < disk_attempts; ++attempt) {
    const int code = disk->pMethods->xRead(disk, bytes.data(), static_cast<int>(bytes.size()), at);
    if (code == SQLITE_OK) return code;
    sqlite3_int64 size = 0;
    if (code == SQLITE_IOERR_SHORT_READ && size_of(file, size) == SQLITE_OK &&
        size < at + static_cast<std::int64_t>(bytes.size())) {
      return code;
    }
  }
  unreadable.fetch_add(1, std::memory_order_relaxed);
  return SQLITE_IOERR_READ;
}

/// Reads the header: pages of 4096 bytes, of which SQLite does not use the last 8.
bool states_checksums(const std::uint8_t* page) {
  return std::memcmp(page, "SQLite format 3", 16) == 0 && page[16] == page_bytes >> 8U && page[17] == 0 &&
         page[20] == page_checksum_bytes;
}

/// Reads it again after a wrong checksum, because the fault may have been in the transfer.
int read_page(CheckedFile& file, Page page, std::int64_t at) {
  const auto number = static_cast<std::uint32_t>(at / static_cast<std::int64_t>(page_bytes)) + 1;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const int code = read_disk(file, page, at);
    // SQLite reads no page after the end, except the first of a new database.
    sqlite3_int64 size = 0;
    if (code == SQLITE_IOERR_SHORT_READ && at == 0) {
      const int sized = size_of(file, size);
      if (sized != SQLITE_OK || size == 0) return sized != SQLITE_OK ? sized : code;
    }
    if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return code;
    if (code == SQLITE_IOERR_SHORT_READ) continue;
    const PageState state = check_page(number, page);
    if (state == PageState::valid) return SQLITE_OK;
    if (state == PageState::mended && attempt > 0) return SQLITE_OK;
  }
  return SQLITE_IOERR_DATA;
}

int read_database(CheckedFile& file, std::span<std::uint8_t> bytes, std::int64_t at) {
  if (!file.checked) return read_disk(file, bytes, at);
  const auto size = static_cast<std::int64_t>(page_bytes);
  if (bytes.size() == page_bytes && at % size == 0) return read_page(file, bytes.first<page_bytes>(), at);
  // SQLite also reads parts of its header.
  std::array<std::uint8_t, page_bytes> page;
  const std::int64_t begin = at % size;
  if (begin + static_cast<std::int64_t>(bytes.size()) > size) return SQLITE_IOERR_DATA;
  const int code = read_page(file, page, at - begin);
  // It does so before it looks into the log, which may have the page: one that was torn while the log was copied is no
  // damage. Later it reads the whole page, from where it is.
  if (code == SQLITE_IOERR_DATA && at < size) return read_disk(file, bytes, at);
  if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return code;
  std::copy_n(page.begin() + begin, bytes.size(), bytes.begin());
  return code;
}

/// Only the copying of the log writes into the database. It may take the room that is reserved for it.
int write_disk(CheckedFile& file, std::span<const std::uint8_t> bytes, std::int64_t at) {
  sqlite3_file* const disk = file.disk();
  const int code = disk->pMethods->xWrite(disk, bytes.data(), static_cast<int>(bytes.size()), at);
  if (code != SQLITE_FULL) return code;
  without_capacity.fetch_add(1, std::memory_order_relaxed);
  if (file.is_log || !release_reserve(file.name)) return code;
  return disk->pMethods->xWrite(disk, bytes.data(), static_cast<int>(bytes.size()), at);
}

int write_database(CheckedFile& file, std::span<const std::uint8_t> bytes, std::int64_t at) {
  const auto size = static_cast<std::int64_t>(page_bytes);
  // The first page decides for a new database.
  if (at == 0) {
    sqlite3_int64 present = 0;
    if (const int code = size_of(file, present); code != SQLITE_OK) return code;
    if (present == 0) file.checked = bytes.size() == page_bytes && states_checksums(bytes.data());
  }
  if (!file.checked) return write_disk(file, bytes, at);
  if (bytes.size() != page_bytes || at % size != 0) return SQLITE_IOERR_WRITE;
  std::array<std::uint8_t, page_bytes> page;
  std::copy(bytes.begin(), bytes.end(), page.begin());
  seal_page(static_cast<std::uint32_t>(at / size) + 1, page);
  return write_disk(file, page, at);
}

std::int64_t place_of(std::int64_t frame) {
  return static_cast<std::int64_t>(log_header_bytes) + frame * static_cast<std::int64_t>(frame_bytes);
}

/// Number of the frame whose header or page begins at `at`, else -1.
std::int64_t frame_at(std::int64_t at, std::size_t part) {
  const std::int64_t place = at - static_cast<std::int64_t>(log_header_bytes + part);
  return place >= 0 && place % static_cast<std::int64_t>(frame_bytes) == 0
             ? place / static_cast<std::int64_t>(frame_bytes)
             : -1;
}

int sum_before(CheckedFile& file, std::int64_t frame, FrameSum& sum) {
  std::array<std::uint8_t, frame_header_bytes> header{};
  // The header of the log ends as that of a frame does.
  constexpr auto of_log = static_cast<std::int64_t>(log_header_bytes - frame_header_bytes);
  const std::int64_t at = frame > 0 ? place_of(frame - 1) : of_log;
  const int code = read_disk(file, header, at);
  sum = stated_frame_sum(header);
  return code;
}

int read_log(CheckedFile& file, std::span<std::uint8_t> bytes, std::int64_t at) {
  const std::int64_t frame = bytes.size() == page_bytes ? frame_at(at, frame_header_bytes) : -1;
  if (frame < 0 || frame >= file.stale) return read_disk(file, bytes, at);
  std::array<std::uint8_t, frame_bytes> whole;
  for (int attempt = 0; attempt < 2; ++attempt) {
    FrameSum sum;
    int code = sum_before(file, frame, sum);
    if (code == SQLITE_OK) code = read_disk(file, whole, at - static_cast<std::int64_t>(frame_header_bytes));
    if (code == SQLITE_IOERR_SHORT_READ) continue;
    if (code != SQLITE_OK) return code;
    const FrameSum stated = stated_frame_sum(std::span(whole).first<frame_header_bytes>());
    for (int order = 0; order < 2; ++order) {
      if (frame_sum(sum, whole, file.big_endian) == stated) {
        std::copy(whole.begin() + frame_header_bytes, whole.end(), bytes.begin());
        return SQLITE_OK;
      }
      // The log may come from a machine with the other byte order.
      file.big_endian = !file.big_endian;
    }
  }
  return SQLITE_IOERR_DATA;
}

/// The log starts over. Before its header is written.
void begin_log(CheckedFile& file, std::span<const std::uint8_t, log_header_bytes> header) {
  std::copy_n(header.begin() + 16, file.salts.size(), file.salts.begin());
  file.written = 0;
  file.stale = none;
  file.ended = true;
  file.unsure = false;
  file.mark.begin(file.salts);
}

/// Before the header of a frame is written.
int prepare_frame(CheckedFile& file, std::span<const std::uint8_t, frame_header_bytes> header, std::int64_t frame) {
  const auto salts = header.subspan<8, 8>();
  // Behind a page that was written alone, salts and checksums are left to the end of the transaction too.
  if (std::all_of(salts.begin(), salts.end(), [](std::uint8_t b) { return b == 0; })) return SQLITE_OK;
  if (!std::equal(salts.begin(), salts.end(), file.salts.begin())) {
    // Another process has begun it.
    std::copy(salts.begin(), salts.end(), file.salts.begin());
    file.written = frame;
    file.stale = none;
    file.unsure = false;
    file.ended = true;
  }
  const bool begins = file.ended || frame < file.written;
  return !begins || file.mark.lower(salts, frame) ? SQLITE_OK : SQLITE_IOERR_WRITE;
}

/// Before the page of the frame is written whose header was written last. What a transaction that was rolled back has
/// left behind it goes: it could end in a whole frame, and then look like a transaction behind damage.
int cut_behind(CheckedFile& file, std::int64_t frame) {
  if (frame + 1 < file.written) {
    sqlite3_file* const disk = file.disk();
    int code = disk->pMethods->xTruncate(disk, place_of(frame) + static_cast<std::int64_t>(frame_header_bytes));
    if (code == SQLITE_OK) code = disk->pMethods->xSync(disk, SQLITE_SYNC_NORMAL);
    if (code != SQLITE_OK) return code;
    file.stale = none;
  }
  if (frame > file.written) file.stale = none;  // other processes have written
  file.written = frame + 1;
  return SQLITE_OK;
}

/// SQLite writes the header of the log, or the header of a frame and then its page. Within a transaction it also writes
/// a page alone into an earlier frame, and before the commit the headers alone of all frames from there on.
int write_log(CheckedFile& file, std::span<const std::uint8_t> bytes, std::int64_t at) {
  if (at == 0 && bytes.size() == log_header_bytes) begin_log(file, bytes.first<log_header_bytes>());
  const std::int64_t header = bytes.size() == frame_header_bytes ? frame_at(at, 0) : -1;
  const std::int64_t page = bytes.size() == page_bytes ? frame_at(at, frame_header_bytes) : -1;
  int code = SQLITE_OK;
  if (header >= 0) code = prepare_frame(file, bytes.first<frame_header_bytes>(), header);
  if (page >= 0 && page == file.headed) code = cut_behind(file, page);
  if (page >= 0 && page != file.headed) file.stale = std::min(file.stale, page);
  if (code == SQLITE_OK) code = write_disk(file, bytes, at);
  if (code != SQLITE_OK || header < 0) {
    file.headed = -1;
    return code;
  }
  file.headed = header;
  file.ended = ends_transaction(bytes.first<frame_header_bytes>());
  if (header == file.stale && ++file.stale >= file.written) file.stale = none;
  return code;
}

struct LogEnd {
  Salts salts{};
  std::int64_t frames = 0;
};

/// The frames up to the last whole one that ends a transaction, of whichever process, from those on that are known to
/// be on the disk.
LogEnd end_of_log(CheckedFile& file) {
  LogEnd end;
  std::array<std::uint8_t, log_header_bytes> head{};
  if (read_disk(file, head, 0) != SQLITE_OK) return end;
  std::copy_n(head.begin() + 16, end.salts.size(), end.salts.begin());
  const bool big_endian = (head[3] & 1U) != 0;
  end.frames = file.mark.frames_of(end.salts);
  FrameSum sum;
  if (sum_before(file, end.frames, sum) != SQLITE_OK) return end;
  std::array<std::uint8_t, frame_bytes> frame;
  const auto header = std::span(frame).first<frame_header_bytes>();
  // Bounded by the log.
  for (std::int64_t k = end.frames; read_disk(file, frame, place_of(k)) == SQLITE_OK; ++k) {
    sum = frame_sum(sum, frame, big_endian);
    if (sum != stated_frame_sum(header) || !std::equal(end.salts.begin(), end.salts.end(), header.begin() + 8)) break;
    if (ends_transaction(header)) end.frames = k + 1;
  }
  return end;
}

/// A call that was interrupted says nothing about the disk. Any other fault is told once, and must not be asked away.
int synchronise_disk(CheckedFile& file, int how) {
  sqlite3_file* const disk = file.disk();
  int code = SQLITE_IOERR_FSYNC;
  for (int attempt = 0; attempt < disk_attempts; ++attempt) {
    int reason = 0;
    code = disk->pMethods->xSync(disk, how);
    if (code == SQLITE_OK || disk->pMethods->xFileControl(disk, SQLITE_FCNTL_LAST_ERRNO, &reason) != SQLITE_OK ||
        reason != EINTR) {
      break;
    }
  }
  return code;
}

int synchronise_log(CheckedFile& file, int how) {
  const LogEnd end = end_of_log(file);
  const int code = synchronise_disk(file, how);
  if (code != SQLITE_OK) file.unsure = true;
  if (!file.unsure) file.mark.write(end.salts, end.frames);
  return code;
}

int on_close(sqlite3_file* base) {
  CheckedFile& file = of(base);
  file.mark.close();
  return file.disk()->pMethods->xClose(file.disk());
}
int on_read(sqlite3_file* base, void* to, int amount, sqlite3_int64 at) {
  CheckedFile& file = of(base);
  const std::span bytes(static_cast<std::uint8_t*>(to), static_cast<std::size_t>(amount));
  const int code = file.is_log ? read_log(file, bytes, at) : read_database(file, bytes, at);
  if (code == SQLITE_IOERR_DATA) refused.fetch_add(1, std::memory_order_relaxed);
  return code;
}
int on_write(sqlite3_file* base, const void* from, int amount, sqlite3_int64 at) {
  CheckedFile& file = of(base);
  const std::span bytes(static_cast<const std::uint8_t*>(from), static_cast<std::size_t>(amount));
  return file.is_log ? write_log(file, bytes, at) : write_database(file, bytes, at);
}
int on_truncate(sqlite3_file* base, sqlite3_int64 bytes) {
  return of(base).disk()->pMethods->xTruncate(of(base).disk(), bytes);
}
int on_sync(sqlite3_file* base, int how) {
  CheckedFile& file = of(base);
  return file.is_log ? synchronise_log(file, how) : synchronise_disk(file, how);
}
int on_file_size(sqlite3_file* base, sqlite3_int64* bytes) {
  return size_of(of(base), *bytes);
}
int on_lock(sqlite3_file* base, int level) {
  return of(base).disk()->pMethods->xLock(of(base).disk(), level);
}
int on_unlock(sqlite3_file* base, int level) {
  return of(base).disk()->pMethods->xUnlock(of(base).disk(), level);
}
int on_check_reserved_lock(sqlite3_file* base, int* held) {
  return of(base).disk()->pMethods->xCheckReservedLock(of(base).disk(), held);
}
int on_file_control(sqlite3_file* base, int operation, void* argument) {
  CheckedFile& file = of(base);
  if (operation == fcntl_pages_are_checked) {
    *static_cast<int*>(argument) = file.checked ? 1 : 0;
    return SQLITE_OK;
  }
  if (operation == fcntl_log_is_deferred)
    return file.is_log && file.mark.defer_synchronisation() ? SQLITE_OK : SQLITE_IOERR_WRITE;
  return file.disk()->pMethods->xFileControl(file.disk(), operation, argument);
}
int on_sector_size(sqlite3_file* base) {
  return of(base).disk()->pMethods->xSectorSize(of(base).disk());
}
int on_device_characteristics(sqlite3_file* base) {
  return of(base).disk()->pMethods->xDeviceCharacteristics(of(base).disk());
}
int on_shm_map(sqlite3_file* base, int page, int size, int extend, void volatile** to) {
  CheckedFile& file = of(base);
  const int code = file.disk()->pMethods->xShmMap(file.disk(), page, size, extend, to);
  // The index of the log is a file too.
  if (code != SQLITE_IOERR_SHMSIZE) return code;
  without_capacity.fetch_add(1, std::memory_order_relaxed);
  if (!release_reserve(file.name)) return code;
  return file.disk()->pMethods->xShmMap(file.disk(), page, size, extend, to);
}
int on_shm_lock(sqlite3_file* base, int offset, int count, int how) {
  return of(base).disk()->pMethods->xShmLock(of(base).disk(), offset, count, how);
}
void on_shm_barrier(sqlite3_file* base) {
  of(base).disk()->pMethods->xShmBarrier(of(base).disk());
}
int on_shm_unmap(sqlite3_file* base, int remove) {
  return of(base).disk()->pMethods->xShmUnmap(of(base).disk(), remove);
}

constexpr sqlite3_io_methods methods(int version) {
  return {version,
          on_close,
          on_read,
          on_write,
          on_truncate,
          on_sync,
          on_file_size,
          on_lock,
          on_unlock,
          on_check_reserved_lock,
          on_file_control,
          on_sector_size,
          on_device_characteristics,
          on_shm_map,
          on_shm_lock,
          on_shm_barrier,
          on_shm_unmap,
          nullptr,
          nullptr};
}
constexpr sqlite3_io_methods with_shared_memory = methods(2);
constexpr sqlite3_io_methods without_shared_memory = methods(1);

sqlite3_vfs* disk_of(sqlite3_vfs* vfs) {
  return static_cast<sqlite3_vfs*>(vfs->pAppData);
}

/// The first page of a database shows it, even with one flipped bit. A new one will have them.
int find_checksums(CheckedFile& file) {
  std::array<std::uint8_t, page_bytes> page{};
  sqlite3_int64 bytes = 0;
  int code = size_of(file, bytes);
  if (code != SQLITE_OK) return code;
  code = read_disk(file, page, 0);
  if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return code;
  file.checked =
      bytes == 0 || states_checksums(page.data()) || (code == SQLITE_OK && check_page(1, page) != PageState::damaged);
  return SQLITE_OK;
}

/// What a process that has ended left in the log may be of transactions that it did not finish.
int find_frames(CheckedFile& file, const char* name, bool writable) {
  std::array<std::uint8_t, log_header_bytes> head{};
  sqlite3_int64 bytes = 0;
  int code = size_of(file, bytes);
  if (code == SQLITE_OK) code = read_disk(file, head, 0);
  if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return code;
  std::copy_n(head.begin() + 16, file.salts.size(), file.salts.begin());
  file.headed = -1;
  file.ended = true;
  file.stale = none;
  const std::int64_t behind_header = bytes - static_cast<std::int64_t>(log_header_bytes);
  const auto size = static_cast<std::int64_t>(frame_bytes);
  file.written = behind_header > 0 ? (behind_header + size - 1) / size : 0;
  return !writable || file.mark.open(name) ? SQLITE_OK : SQLITE_CANTOPEN;
}

int open_file(sqlite3_vfs* vfs, const char* name, sqlite3_file* base, int flags, int* flags_out) {
  sqlite3_vfs* const disk = disk_of(vfs);
  if ((flags & (SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_WAL)) == 0) return disk->xOpen(disk, name, base, flags, flags_out);
  auto* const file = new (base) CheckedFile{};
  file->is_log = (flags & SQLITE_OPEN_WAL) != 0;
  file->name = name;
  const int code = disk->xOpen(disk, name, file->disk(), flags, flags_out);
  if (file->disk()->pMethods == nullptr) return code;
  base->pMethods = file->disk()->pMethods->iVersion >= 2 ? &with_shared_memory : &without_shared_memory;
  if (code != SQLITE_OK) return code;
  // SQLite closes it after a fault.
  return file->is_log ? find_frames(*file, name, (flags & SQLITE_OPEN_READWRITE) != 0) : find_checksums(*file);
}
int delete_file(sqlite3_vfs* vfs, const char* name, int sync) {
  // Before the log is removed, because otherwise the mark would report a lost log.
  if (!remove_log_mark(name)) return SQLITE_IOERR_DELETE;
  return disk_of(vfs)->xDelete(disk_of(vfs), name, sync);
}
int access_file(sqlite3_vfs* vfs, const char* name, int flags, int* result) {
  return disk_of(vfs)->xAccess(disk_of(vfs), name, flags, result);
}
int full_path_name(sqlite3_vfs* vfs, const char* name, int bytes, char* out) {
  return disk_of(vfs)->xFullPathname(disk_of(vfs), name, bytes, out);
}
int randomness(sqlite3_vfs* vfs, int bytes, char* out) {
  return disk_of(vfs)->xRandomness(disk_of(vfs), bytes, out);
}
int sleep_for(sqlite3_vfs* vfs, int microseconds) {
  return disk_of(vfs)->xSleep(disk_of(vfs), microseconds);
}
int current_time(sqlite3_vfs* vfs, double* days) {
  return disk_of(vfs)->xCurrentTime(disk_of(vfs), days);
}
int last_error(sqlite3_vfs* vfs, int bytes, char* out) {
  return disk_of(vfs)->xGetLastError(disk_of(vfs), bytes, out);
}

sqlite3_vfs checked_disk = {1,         0,           0,           nullptr,        checked_vfs,  nullptr,
                            open_file, delete_file, access_file, full_path_name, nullptr,      nullptr,
                            nullptr,   nullptr,     randomness,  sleep_for,      current_time, last_error,
                            nullptr,   nullptr,     nullptr,     nullptr};

}  // namespace

int register_checked_vfs() {
  sqlite3_vfs* const disk = sqlite3_vfs_find(nullptr);
  if (disk == nullptr) return SQLITE_ERROR;
  if (sqlite3_vfs_find(checked_vfs) != nullptr && checked_disk.pAppData == disk) return SQLITE_OK;
  checked_disk.pAppData = disk;
  // Open databases will use their log's size, so it must never shrink.
  checked_disk.szOsFile =
      std::max(checked_disk.szOsFile, static_cast<int>(CheckedFile::place_of_disk()) + disk->szOsFile);
  checked_disk.mxPathname = disk->mxPathname;
  return sqlite3_vfs_register(&checked_disk, 0);
}

std::int64_t refused_reads() {
  return refused.load(std::memory_order_relaxed);
}

std::int64_t failed_reads() {
  return unreadable.load(std::memory_order_relaxed);
}

std::int64_t writes_without_capacity() {
  return without_capacity.load(std::memory_order_relaxed);
}

}  // namespace ilp
