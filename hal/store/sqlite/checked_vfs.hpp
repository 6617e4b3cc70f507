// SQLite's file access with a checksum on every page of a database and a check of every frame of its log.
#pragma once

#include <cstdint>

namespace ilp {

inline constexpr const char* checked_vfs = "ilp-checked";

/// Registers a layer over the present default VFS; returns SQLite's code. A page with a wrong checksum is read again,
/// then one flipped bit is mended; if it is still wrong the result is SQLITE_IOERR_DATA. The same holds for a frame of
/// the log. A read that fails is tried `disk_attempts` times, and is then SQLITE_IOERR_READ, which says nothing about
/// the content. Databases without checksums are read and written as they are: see `pages_are_checked`. After every
/// synchronisation of a log, the file `NAME-sync` notes its length. If the disk has no room for a page of the database,
/// or for the index of the log, its reserve is released (reserve.hpp).
int register_checked_vfs();

/// Reads that were refused because of damage, in this process. SQLite does not return every fault: a failure while it
/// copies the log into the database is tried again with the next commit.
[[nodiscard]] std::int64_t refused_reads();

/// Reads that failed, in this process, however often they were tried.
[[nodiscard]] std::int64_t failed_reads();
/// Writes that found no room on the disk, in this process.
[[nodiscard]] std::int64_t writes_without_capacity();

/// SQLITE_FCNTL: an int, 1 when the pages of this database have checksums (SQLite leaves 100 and above to VFSs).
inline constexpr int fcntl_pages_are_checked = 0x494C50;
/// For the file of a log, without argument: LogMark::defer_synchronisation().
inline constexpr int fcntl_log_is_deferred = 0x494C51;

}  // namespace ilp
