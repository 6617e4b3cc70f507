#include "hal/store/sqlite/checked_vfs.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <limits>
#include <new>
#include <span>

#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/page_checksum.hpp"

namespace ilp {
namespace {

constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();

std::atomic<std::int64_t> refused{0};

/// A database or its log; the underlying VFS's file follows.
struct CheckedFile {
  sqlite3_file base;
  bool is_log;
  bool checked;  ///< a database whose pages have checksums
  bool big_endian;
  // For a log. Frames count from 0.
  std::int64_t headed;   ///< frame whose header was written last: its page follows
  std::int64_t written;  ///< frames that this connection knows of
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

int read_disk(CheckedFile& file, std::span<std::uint8_t> bytes, std::int64_t at) {
  sqlite3_file* const disk = file.disk();
  return disk->pMethods->xRead(disk, bytes.data(), static_cast<int>(bytes.size()), at);
}

bool is_empty(CheckedFile& file) {
  sqlite3_int64 bytes = 0;
  return file.disk()->pMethods->xFileSize(file.disk(), &bytes) == SQLITE_OK && bytes == 0;
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
    if (code == SQLITE_IOERR_SHORT_READ && at == 0 && is_empty(file)) return code;
    if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return code;
    if (code == SQLITE_IOERR_SHORT_READ) continue;
    const PageState state = check_page(number, page);
    if (state == PageState::sound) return SQLITE_OK;
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
  if (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ) return code;
  std::copy_n(page.begin() + begin, bytes.size(), bytes.begin());
  return code;
}

int write_database(CheckedFile& file, std::span<const std::uint8_t> bytes, std::int64_t at) {
  sqlite3_file* const disk = file.disk();
  const auto size = static_cast<std::int64_t>(page_bytes);
  // The first page decides for a new database.
  if (at == 0 && is_empty(file)) file.checked = bytes.size() == page_bytes && states_checksums(bytes.data());
  if (!file.checked) return disk->pMethods->xWrite(disk, bytes.data(), static_cast<int>(bytes.size()), at);
  if (bytes.size() != page_bytes || at % size != 0) return SQLITE_IOERR_WRITE;
  std::array<std::uint8_t, page_bytes> page;
  std::copy(bytes.begin(), bytes.end(), page.begin());
  seal_page(static_cast<std::uint32_t>(at / size) + 1, page);
  return disk->pMethods->xWrite(disk, page.data(), static_cast<int>(page.size()), at);
}

/// Number of the frame whose header or page begins at `at`, else -1.
std::int64_t frame_at(std::int64_t at, std::size_t part) {
  const std::int64_t place = at - static_cast<std::int64_t>(log_header_bytes + part);
  return place >= 0 && place % static_cast<std::int64_t>(frame_bytes) == 0
             ? place / static_cast<std::int64_t>(frame_bytes)
             : -1;
}

int sum_before(CheckedFile& file, std::int64_t frame, FrameSum& sum) {
  const auto at = static_cast<std::int64_t>(log_header_bytes) + frame * static_cast<std::int64_t>(frame_bytes);
  std::array<std::uint8_t, frame_header_bytes> header{};
  if (frame > 0) {
    const int code = read_disk(file, header, at - static_cast<std::int64_t>(frame_bytes));
    sum = stated_frame_sum(header);
    return code;
  }
  std::array<std::uint8_t, log_header_bytes> head;
  const int code = read_disk(file, head, 0);
  sum = stated_frame_sum(std::span(head).subspan<log_header_bytes - frame_header_bytes>());
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

void note_log_write(CheckedFile& file, std::span<const std::uint8_t> bytes, std::int64_t at) {
  if (at == 0) {
    file.written = 0;
    file.headed = -1;
    file.stale = none;
    return;
  }
  if (bytes.size() == frame_header_bytes) {
    const std::int64_t frame = frame_at(at, 0);
    if (frame < 0) return;
    file.headed = frame;
    file.mark.note(bytes.first<frame_header_bytes>(), frame);
    if (frame >= file.written) {
      file.written = frame + 1;
    } else if (frame == file.stale && ++file.stale == file.written) {
      file.stale = none;
    }
  } else {
    const std::int64_t frame = frame_at(at, frame_header_bytes);
    if (frame >= 0 && frame != file.headed) file.stale = std::min(file.stale, frame);
    file.headed = -1;
  }
}

bool is_whole(CheckedFile& file, std::int64_t frame, std::span<std::uint8_t, frame_bytes> bytes) {
  FrameSum before;
  const auto at = static_cast<std::int64_t>(log_header_bytes) + frame * static_cast<std::int64_t>(frame_bytes);
  if (sum_before(file, frame, before) != SQLITE_OK || read_disk(file, bytes, at) != SQLITE_OK) return false;
  const FrameSum stated = stated_frame_sum(bytes.first<frame_header_bytes>());
  return frame_sum(before, bytes, false) == stated || frame_sum(before, bytes, true) == stated;
}

/// Notes the latest commit of other processes behind the frames that are noted. Call it before the log is synchronised.
void note_others(CheckedFile& file) {
  std::array<std::uint8_t, log_header_bytes> head{};
  if (read_disk(file, head, 0) != SQLITE_OK) return;
  const auto salts = std::span(head).subspan<16, 8>();
  std::array<std::uint8_t, frame_header_bytes> header{};
  std::array<std::uint8_t, frame_bytes> frame;
  std::int64_t ends[2] = {-1, -1};
  // Ends with the log.
  for (std::int64_t k = file.mark.frames_of(salts);; ++k) {
    const auto at = static_cast<std::int64_t>(log_header_bytes) + k * static_cast<std::int64_t>(frame_bytes);
    if (read_disk(file, header, at) != SQLITE_OK || !std::equal(salts.begin(), salts.end(), header.begin() + 8)) break;
    if (!ends_transaction(header)) continue;
    ends[0] = ends[1];
    ends[1] = k;
  }
  // The page of the last one may be on its way.
  for (const std::int64_t end : {ends[1], ends[0]}) {
    if (end < 0 || !is_whole(file, end, frame)) continue;
    file.mark.note(std::span(frame).first<frame_header_bytes>(), end);
    return;
  }
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
  if (!file.is_log) return write_database(file, bytes, at);
  const int code = file.disk()->pMethods->xWrite(file.disk(), from, amount, at);
  if (code == SQLITE_OK) note_log_write(file, bytes, at);
  return code;
}
int on_truncate(sqlite3_file* base, sqlite3_int64 bytes) {
  return of(base).disk()->pMethods->xTruncate(of(base).disk(), bytes);
}
int on_sync(sqlite3_file* base, int how) {
  CheckedFile& file = of(base);
  if (file.is_log && file.mark.loose()) note_others(file);
  const int code = file.disk()->pMethods->xSync(file.disk(), how);
  if (file.is_log && code == SQLITE_OK) file.mark.write();
  return code;
}
int on_file_size(sqlite3_file* base, sqlite3_int64* bytes) {
  return of(base).disk()->pMethods->xFileSize(of(base).disk(), bytes);
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
  if (operation == fcntl_log_is_loose) return file.is_log && file.mark.be_loose() ? SQLITE_OK : SQLITE_IOERR_WRITE;
  return file.disk()->pMethods->xFileControl(file.disk(), operation, argument);
}
int on_sector_size(sqlite3_file* base) {
  return of(base).disk()->pMethods->xSectorSize(of(base).disk());
}
int on_device_characteristics(sqlite3_file* base) {
  return of(base).disk()->pMethods->xDeviceCharacteristics(of(base).disk());
}
int on_shm_map(sqlite3_file* base, int page, int size, int extend, void volatile** to) {
  return of(base).disk()->pMethods->xShmMap(of(base).disk(), page, size, extend, to);
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

/// For an existing database: its first page shows it, even with one flipped bit.
bool has_checksums(CheckedFile& file) {
  std::array<std::uint8_t, page_bytes> page{};
  const int code = read_disk(file, page, 0);
  return states_checksums(page.data()) || (code == SQLITE_OK && check_page(1, page) != PageState::damaged);
}

int open_file(sqlite3_vfs* vfs, const char* name, sqlite3_file* base, int flags, int* flags_out) {
  sqlite3_vfs* const disk = disk_of(vfs);
  if ((flags & (SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_WAL)) == 0) return disk->xOpen(disk, name, base, flags, flags_out);
  auto* const file = new (base) CheckedFile{};
  file->is_log = (flags & SQLITE_OPEN_WAL) != 0;
  file->headed = -1;
  file->stale = none;
  const int code = disk->xOpen(disk, name, file->disk(), flags, flags_out);
  if (file->disk()->pMethods == nullptr) return code;
  base->pMethods = file->disk()->pMethods->iVersion >= 2 ? &with_shared_memory : &without_shared_memory;
  if (code != SQLITE_OK) return code;
  if (!file->is_log) {
    file->checked = is_empty(*file) || has_checksums(*file);
  } else if ((flags & SQLITE_OPEN_READWRITE) != 0) {
    file->mark.open(name);
  }
  return code;
}
int delete_file(sqlite3_vfs* vfs, const char* name, int sync) {
  // Before the log is removed, because otherwise the mark would report a lost log.
  remove_log_mark(name);
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

}  // namespace ilp
