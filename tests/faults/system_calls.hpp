// The operating system's calls on the files of a flight, as SQLite's unix VFS and the flight's own code make them. The
// linker sends them here (--wrap, tests/faults/CMakeLists.txt), so this layer lies below SQLite's file layer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>

namespace ilp::faults {

enum class CallKind : std::uint8_t { open, read, write, allocate, truncate, sync, unlink, rename, map, kinds };
[[nodiscard]] const char* call_name(CallKind kind);

enum class FileKind : std::uint8_t {
  database,
  log,
  index,      ///< of the log
  mark,       ///< NAME-sync
  guard,      ///< NAME-guard
  memory,     ///< NAME.keep-*
  reserve,    ///< NAME-reserve
  successor,  ///< a database that is being saved, or is quarantined
  folder,
  link,  ///< outbox and confirmations
  kinds
};
[[nodiscard]] const char* file_name(FileKind kind);

struct SystemCall {
  CallKind kind = CallKind::open;
  FileKind file = FileKind::database;
  bool grows = false;     ///< takes more of the disk: makes a file, or writes behind the blocks that it has
  std::size_t bytes = 0;  ///< that are to be read or written
  std::size_t fits = 0;   ///< of these: in blocks that the file has
  std::size_t frees = 0;  ///< octets that it gives back to the disk
};

/// How a call ends.
struct Answer {
  int error = 0;                                               ///< errno: the call does nothing and fails
  std::size_t most = std::numeric_limits<std::size_t>::max();  ///< octets of a read or a write that is cut short
  bool dies = false;                                           ///< `end` is called afterwards
};

/// What is told of calls that were carried out, for a model of the disk (tests/faults/cut_disk.hpp). Paths are those of
/// the call; a file is given by its descriptor.
class DiskWatch {
 public:
  virtual void opened(const std::filesystem::path& path, int file) = 0;
  virtual void wrote(int file, std::int64_t at, std::size_t bytes) = 0;
  virtual void synchronised(int file, bool done) = 0;
  virtual void synchronised_folder() = 0;
  virtual void unlinks(const std::filesystem::path& path) = 0;  ///< before it is done
  virtual void renamed(const std::filesystem::path& from, const std::filesystem::path& to) = 0;

 protected:
  ~DiskWatch() = default;
};

struct SystemCallHooks {
  std::function<Answer(const SystemCall&)> judge;
  std::function<void()> end;  ///< does not return
  DiskWatch* disk = nullptr;
};

/// From now on the calls of this process on `folder`/flight.db*, the outbox and the confirmations are judged, and
/// the disk's room is as `set_capacity` says.
void watch_system_calls(const std::filesystem::path& folder, SystemCallHooks hooks);
void forget_system_calls();
/// Octets that statvfs() reports as free; -1: the real ones.
void set_capacity(std::int64_t bytes);
/// From now on this process and its children sleep without waiting: their clocks advance by a hundred times as much.
void sleep_no_more();

}  // namespace ilp::faults
