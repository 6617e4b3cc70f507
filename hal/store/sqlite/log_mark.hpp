// How far a database's log is known to have reached the disk: what a flipped bit in its last transaction is told by,
// which would else look as if the transaction had never been finished.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "hal/store/sqlite/page_checksum.hpp"

namespace ilp {

inline constexpr const char* log_suffix = "-wal";
inline constexpr const char* mark_suffix = "-sync";

/// Kept in a file beside the log. It is written after the log was synchronised and never synchronised itself: it may
/// tell less than is true, but never more. Faults are of no account.
class LogMark {
 public:
  /// `log`: name of the log.
  void open(const char* log);
  void close();
  /// A header of a frame that was written.
  void note(std::span<const std::uint8_t, frame_header_bytes> header, std::int64_t frame);
  /// All that was noted is on the disk.
  void write();

 private:
  int file_ = -1;
  bool news_ = false;
  std::uint8_t salts_[8] = {};
  std::int64_t frames_ = 0;  ///< up to the end of the last transaction
};

/// Nothing for names that are not a log's.
void remove_log_mark(const char* log);

/// Before the database at `path` is opened: `log_damaged` (a = frame, b = frames that are known to have been written)
/// when its log has frames that do not have their checksums, but for a last transaction that was never finished.
/// What SQLite makes of such a log is what stands before the damage. Nobody may be writing.
Status check_log(const char* path);

/// Mends a log in whose frames single bits have flipped, where the checksums say which. `log_damaged` where they do
/// not, or more is wrong: nothing was changed then that was right.
Status mend_log(const char* path);

/// Makes a log with damaged frames readable to its end. SQLite then takes them as they are: the checksums of records
/// and blobs tell what of them is right. `frames` is their number.
Status bridge_log(const char* path, std::int64_t& frames);

}  // namespace ilp
