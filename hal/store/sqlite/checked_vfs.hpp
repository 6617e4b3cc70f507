// SQLite's file access with a checksum on every page of a database and a check of every frame of its log.
#pragma once

#include <cstdint>

namespace ilp {

inline constexpr const char* checked_vfs = "ilp-checked";

/// Registers a layer over the present default VFS. Returns SQLite's code. If a page of a database or a frame of a log
/// has a wrong checksum, it is read again, then one flipped bit is corrected; if it is still wrong, the read returns
/// SQLITE_IOERR_DATA. A read that fails is tried `disk_attempts` times, then it returns SQLITE_IOERR_READ, which says
/// nothing about the content. Databases without checksums are read and written unchanged: see fcntl_pages_are_checked.
/// After every synchronisation of a log, its length is written to the file `NAME-sync` (log_mark.hpp). If the disk has
/// no space for a page of the database, or for the index of the log, the reserve is released (reserve.hpp).
int register_checked_vfs();

/// Number of reads in this process that were refused because of damage. SQLite does not report every fault: if copying
/// the log into the database fails, it tries again with the next commit.
[[nodiscard]] std::int64_t refused_reads();

/// Number of reads in this process that failed after all attempts.
[[nodiscard]] std::int64_t failed_reads();
/// Number of writes in this process that found no free space on the disk.
[[nodiscard]] std::int64_t writes_without_capacity();

/// Operation of sqlite3_file_control() that writes an int: 1 if the pages of this database have checksums. (SQLite
/// leaves codes from 100 on to VFSs.)
inline constexpr int fcntl_pages_are_checked = 0x494C50;
/// Operation on the file of a log, without an argument: calls LogMark::defer_synchronisation().
inline constexpr int fcntl_log_is_deferred = 0x494C51;

}  // namespace ilp
