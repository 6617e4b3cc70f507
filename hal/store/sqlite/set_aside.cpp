#include "hal/store/sqlite/set_aside.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <initializer_list>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"

namespace ilp {
namespace {

using Path = FixedText<limits::max_path_bytes>;

Path aside(const char* path, std::int64_t number) {
  Path to;
  to.add(path).add(".aside-").add(number);
  return to;
}

Status move(const Path& from, const Path& to) {
  if (from.overflow() || to.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  if (std::rename(from.c_str(), to.c_str()) == 0) return {};
  // What it would have replaced belongs to another database.
  if (errno == ENOENT && (::unlink(to.c_str()) == 0 || errno == ENOENT)) return {};
  return {StatusCode::io_error, errno};
}

}  // namespace

Status set_database_aside(const char* path, std::int64_t& number) {
  number = 1;
  while (number < max_set_aside && ::access(aside(path, number).c_str(), F_OK) == 0) ++number;
  // The log first: a log without its database would be taken for one of the next.
  for (const char* const suffix : {"-wal", "-shm", ""}) {
    Path from;
    from.add(path).add(suffix);
    Path to = aside(path, number);
    to.add(suffix);
    ILP_TRY(move(from, to));
  }
  return {};
}

}  // namespace ilp
