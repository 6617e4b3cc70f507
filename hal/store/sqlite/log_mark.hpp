// The length of a database's log that is known to be on the disk. It reveals a flipped bit in the last transaction,
// which would otherwise look like a transaction that was never finished.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "hal/store/sqlite/page_checksum.hpp"

namespace ilp {

inline constexpr const char* log_suffix = "-wal";
inline constexpr const char* mark_suffix = "-sync";

/// Kept in a file beside the log. It is written after the log was synchronised and not synchronised itself: it may
/// understate the length, but never overstate it. It is made from the frames that are in the log, never from the calls
/// that wrote them, because any of these may have failed. A frame is counted by its end, so a length is a number of
/// frames.
class LogMark {
 public:
  /// `log` is the name of the log. False if there may be a mark that cannot be written.
  [[nodiscard]] bool open(const char* log);
  void close();
  /// Before the header of a log is written that starts over: nothing of it is needed yet. A fault is ignored.
  void begin(std::span<const std::uint8_t, 8> salts);
  /// Before frames are written in the place of others, which a transaction has left that was rolled back: the mark
  /// states at most `frames` from now on, which is synchronised. If false, they must not be written.
  [[nodiscard]] bool lower(std::span<const std::uint8_t, 8> salts, std::int64_t frames);
  /// So many frames of the log with these salts are on the disk. A fault is ignored.
  void write(std::span<const std::uint8_t, 8> salts, std::int64_t frames);
  /// From now on transactions are not synchronised one by one: several may be behind the mark, and after a power cut
  /// any part of them may be on the disk. The next check_log() has to know it, so this is written through.
  bool defer_synchronisation();
  /// Frames of the log with these salts that this process knows to be on the disk.
  [[nodiscard]] std::int64_t frames_of(std::span<const std::uint8_t, 8> salts) const;

 private:
  int file_ = -1;
  bool deferred_ = false;
  std::uint8_t salts_[8] = {};
  std::int64_t frames_ = 0;  ///< up to the end of a transaction
};

/// Does nothing for names that are not a log's. False if it is still there.
[[nodiscard]] bool remove_log_mark(const char* log);

/// Call it before the database at `path` is opened. `log_damaged` (a = frame, b = frames that are known to have been
/// written) when its log has frames with wrong checksums, except those of a last transaction that was never finished.
/// SQLite uses such a log up to the damage. No process may be writing. Here and below `io_error` (a = errno) says that
/// it could not be read, which is no verdict.
Status check_log(const char* path);

/// Mends a log with single flipped bits, if the checksums determine them. `log_damaged` if they do not, or if more is
/// wrong; correct data is never changed.
Status mend_log(const char* path);

/// Makes a log with damaged frames readable to its end. SQLite then takes them as they are; the checksums of records
/// and blobs show which of their data is right.
Status bridge_log(const char* path);

}  // namespace ilp
