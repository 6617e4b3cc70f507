// SQLite's way to the disk with a checksum on every page of a database, and a look at every frame of its log.
#pragma once

#include <cstdint>

namespace ilp {

inline constexpr const char* checked_vfs = "ilp-checked";

/// Lays itself over the default VFS of now; SQLite's code. A page that does not have its checksum is read again, then
/// one flipped bit is mended, and what is still wrong is SQLITE_IOERR_DATA. So is a frame of the log. Databases that
/// have no checksums are read and written as they are: see `pages_are_checked`. Behind every synchronised log stands in
/// a file of its own, `NAME-sync`, how far it goes.
int register_checked_vfs();

/// Pages in which a bit was mended, and reads that were refused because of damage, in this process. SQLite does not
/// pass on every fault: what fails while it folds the log into the database is tried again with the next commit.
[[nodiscard]] std::int64_t mended_pages();
[[nodiscard]] std::int64_t refused_reads();

/// SQLITE_FCNTL: an int, 1 when the pages of this database have checksums (SQLite leaves 100 and above to VFSs).
inline constexpr int fcntl_pages_are_checked = 0x494C50;

}  // namespace ilp
