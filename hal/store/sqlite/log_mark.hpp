// Records the length of a database's log that is known to be on the disk (the mark), and checks and repairs logs. The
// mark reveals a flipped bit in the last transaction, which would otherwise look like an unfinished transaction.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "hal/store/sqlite/page_checksum.hpp"

namespace ilp {

inline constexpr const char* log_suffix = "-wal";
inline constexpr const char* mark_suffix = "-sync";

/// The mark, in a file next to the log. It is written after the log was synchronised, and is not synchronised itself:
/// its length may be too small, but never too large. It is computed from the frames in the log, not from the calls that
/// wrote them, because a call may have failed. A length is a number of frames.
class LogMark {
 public:
  /// Opens the mark of `log`, the path of a log. Returns false if there may be a mark that cannot be written.
  [[nodiscard]] bool open(const char* log);
  void close();
  /// Call it before the header of a restarted log is written: no frame of the log is needed yet. A fault is ignored.
  void begin(std::span<const std::uint8_t, 8> salts);
  /// Call it before frames of a rolled-back transaction are overwritten. Lowers the mark to at most `frames` and
  /// synchronises it. If it returns false, the frames must not be written.
  [[nodiscard]] bool lower(std::span<const std::uint8_t, 8> salts, std::int64_t frames);
  /// Records that `frames` frames of the log with these salts are on the disk. A fault is ignored.
  void write(std::span<const std::uint8_t, 8> salts, std::int64_t frames);
  /// Records, and synchronises, that transactions are no longer synchronised one by one. Several may then be beyond the
  /// mark, and after a power cut any part of them may be on the disk; the next check_log() must know this. Returns
  /// false after a fault.
  bool defer_synchronisation();
  /// Number of frames of the log with these salts that this process knows to be on the disk.
  [[nodiscard]] std::int64_t frames_of(std::span<const std::uint8_t, 8> salts) const;

 private:
  int file_ = -1;
  bool deferred_ = false;
  std::uint8_t salts_[8] = {};
  std::int64_t frames_ = 0;  ///< number of frames, up to the end of a transaction
};

/// Removes the mark of a log. Does nothing if `log` is no log's name. Returns false if the mark cannot be removed.
[[nodiscard]] bool remove_log_mark(const char* log);

/// Checks the log of the database at `path`. Call it before the database is opened, while no process writes. Returns
/// `log_damaged` (a = frame, b = frames that are known to have been written) if frames have wrong checksums; frames of
/// an unfinished last transaction are allowed. SQLite would use such a log up to the damage. This function and the next
/// two return `io_error` (a = errno) if the log cannot be read, which is no verdict.
Status check_log(const char* path);

/// Corrects single flipped bits in a log, if the checksums determine them. Returns `log_damaged` if they do not, or if
/// there is more damage. Correct data is never changed.
Status mend_log(const char* path);

/// Makes a log with damaged frames readable to its end. SQLite then accepts these frames; the checksums of records and
/// blobs show which of their data is valid.
Status bridge_log(const char* path);

}  // namespace ilp
