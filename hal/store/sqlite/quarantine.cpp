#include "hal/store/sqlite/quarantine.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/sqlite/disk_file.hpp"

namespace ilp {
namespace {

using Path = FixedText<limits::max_path_bytes>;

Path quarantine_path(const char* path, std::int64_t number) {
  Path to;
  to.add(path).add(".aside-").add(number);
  return to;
}

// The log is moved first, because a log without its database would be used for the next one. The mark of its length is
// moved before it, because without the log it would report a loss.
constexpr const char* suffixes[] = {"-sync", "-wal", "-shm", ""};

Path with(Path path, const char* suffix) {
  path.add(suffix);
  return path;
}

/// An interrupted start may have moved some of it already.
Status move(const Path& from, const Path& to) {
  if (from.overflow() || to.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  return std::rename(from.c_str(), to.c_str()) == 0 || errno == ENOENT ? Status{} : Status{StatusCode::io_error, errno};
}

Status remove(const Path& path) {
  return ::unlink(path.c_str()) == 0 || errno == ENOENT ? Status{} : Status{StatusCode::io_error, errno};
}

}  // namespace

Status quarantine_database(const char* path, std::int64_t& number) {
  bool taken = true;
  for (number = 1; number <= max_quarantined; ++number) {
    ILP_TAKE(taken, look_for(quarantine_path(path, number).c_str()));
    if (!taken) break;
  }
  number = std::min(number, max_quarantined);
  const Path to = quarantine_path(path, number);
  if (taken) {
    for (const char* const suffix : suffixes) ILP_TRY(remove(with(to, suffix)));
  }
  Path from;
  from.add(path);
  for (const char* const suffix : suffixes) ILP_TRY(move(with(from, suffix), with(to, suffix)));
  return {};
}

}  // namespace ilp
