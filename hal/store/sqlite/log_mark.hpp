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

/// Kept in a file beside the log. It is written after the log was synchronised and never synchronised itself: it may
/// understate the length, but never overstate it. Faults are ignored.
class LogMark {
 public:
  /// `log` is the name of the log.
  void open(const char* log);
  void close();
  /// Takes the header of a written frame.
  void note(std::span<const std::uint8_t, frame_header_bytes> header, std::int64_t frame);
  /// All frames noted so far are on the disk: writes the mark.
  void write();
  /// From now on transactions are not synchronised one by one: several may be behind the mark, and after a power cut
  /// any part of them may be on the disk. The next check_log() has to know it, so this is written through.
  bool be_loose();
  /// Other processes write the log too.
  [[nodiscard]] bool loose() const { return loose_; }
  /// Frames noted so far of the log that began with these salts.
  [[nodiscard]] std::int64_t frames_of(std::span<const std::uint8_t, 8> salts) const;

 private:
  int file_ = -1;
  bool news_ = false;
  bool loose_ = false;
  std::uint8_t salts_[8] = {};
  std::int64_t frames_ = 0;  ///< frames up to the end of the last transaction
};

/// Does nothing for names that are not a log's.
void remove_log_mark(const char* log);

/// Call it before the database at `path` is opened. `log_damaged` (a = frame, b = frames that are known to have been
/// written) when its log has frames with wrong checksums, except those of a last transaction that was never finished.
/// SQLite uses such a log up to the damage. No process may be writing. `loose_end`: behind its end there are frames of
/// transactions that a power cut has undone. They must not stay behind new ones, which they would make look damaged.
Status check_log(const char* path, bool* loose_end = nullptr);

/// Mends a log with single flipped bits, if the checksums determine them. `log_damaged` if they do not, or if more is
/// wrong; correct data is never changed.
Status mend_log(const char* path);

/// Makes a log with damaged frames readable to its end. SQLite then takes them as they are; the checksums of records
/// and blobs show which of their data is right. `frames` is their number.
Status bridge_log(const char* path, std::int64_t& frames);

}  // namespace ilp
