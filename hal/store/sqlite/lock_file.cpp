#include "hal/store/sqlite/lock_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"

namespace ilp {
namespace {

/// WAL_WRITE_LOCK among the bytes that SQLite locks in the index ("WAL-mode File Format", 2.3.1).
constexpr off_t writers_byte = 120;

}  // namespace

int LockFile::holder(const char* path) {
  if (file_ < 0) {
    FixedText<limits::max_path_bytes + 16> name;
    name.add(path).add("-shm");
    if (!name.overflow()) file_ = ::open(name.c_str(), O_RDWR | O_CLOEXEC);
  }
  if (file_ < 0) return 0;
  struct flock range {};
  range.l_type = F_WRLCK;
  range.l_whence = SEEK_SET;
  range.l_start = writers_byte;
  range.l_len = 1;
  if (::fcntl(file_, F_GETLK, &range) != 0 || range.l_type == F_UNLCK) return 0;
  return range.l_pid > 0 ? static_cast<int>(range.l_pid) : -1;
}

void LockFile::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

}  // namespace ilp
