#include "hal/nonvolatile/file_nonvolatile.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "hal/posix/file.hpp"

namespace ilp {
namespace {

using Path = FixedText<limits::max_path_bytes>;

/// Precedes the content; the checksum covers the rest of the block.
struct Head {
  std::uint32_t crc32 = 0;
  std::uint32_t magic = 0;
  std::uint64_t number = 0;
  std::uint32_t bytes = 0;
  std::uint32_t file = 0;
};
constexpr std::uint32_t magic = 0x4B504C49;  // "ILPK"
static_assert(sizeof(Head) == 24);

Status failure() {
  return {StatusCode::io_error, errno};
}

}  // namespace

Status FileNonvolatile::open_one(const char* path, std::size_t file) {
  Path name;
  name.add(path).add(".keep-").add(static_cast<std::int64_t>(file + 1));
  if (name.overflow()) return {StatusCode::capacity_exceeded, 0, limits::max_path_bytes};
  int descriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  const bool only_for_reading = descriptor < 0 && (errno == EROFS || errno == EACCES);
  if (only_for_reading) descriptor = ::open(name.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return failure();
  files_[file] = descriptor;
  if (only_for_reading) return {};
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return failure();
  struct stat state {};
  if (::fstat(descriptor, &state) != 0) return failure();
  constexpr auto whole = static_cast<off_t>(copies * block_bytes);
  if (state.st_size >= whole) return {};
  // The file is written and not only reserved, so that the room is allocated on every file system.
  block_ = {};
  if (::lseek(descriptor, state.st_size, SEEK_SET) < 0) return failure();
  for (auto size = state.st_size; size < whole;) {
    const auto chunk = std::min(static_cast<std::size_t>(whole - size), block_bytes);
    ILP_TRY(write_all(descriptor, std::span<const std::uint8_t>(block_).first(chunk)));
    size += static_cast<off_t>(chunk);
  }
  if (::fsync(descriptor) != 0) return failure();
  // A new file survives a power cut only when its folder was synchronised too.
  return synchronise_folder_of(name.c_str());
}

Status FileNonvolatile::open(const char* path) {
  close();
  Status status;
  for (std::size_t file = 0; file < files && status.ok(); ++file) status = open_one(path, file);
  if (!status.ok()) close();
  return status;
}

void FileNonvolatile::close() {
  for (int& file : files_) {
    if (file >= 0) ::close(file);
    file = -1;
  }
  known_ = false;
}

bool FileNonvolatile::load(std::size_t file, std::uint64_t& number, std::size_t& bytes, bool& anything) {
  for (std::size_t copy = 0; copy < copies; ++copy) {
    std::size_t size = 0;
    if (::lseek(files_[file], static_cast<off_t>(copy * block_bytes), SEEK_SET) < 0) continue;
    if (!read_some(files_[file], block_, size).ok() || size != block_bytes) continue;
    Head head;
    std::memcpy(&head, block_.data(), sizeof(head));
    anything = anything || std::any_of(block_.begin(), block_.end(), [](std::uint8_t octet) { return octet != 0; });
    const std::uint32_t crc = crc32(std::span<const std::uint8_t>(block_).subspan(sizeof(head.crc32)));
    if (head.magic != magic || head.crc32 != crc || head.file != file || head.number == 0) continue;
    if (head.bytes > block_bytes - sizeof(head)) continue;
    number = head.number;
    bytes = head.bytes;
    return true;
  }
  return false;
}

Status FileNonvolatile::read(std::span<std::uint8_t> content, std::size_t& bytes) {
  bytes = 0;
  if (files_[0] < 0) return {StatusCode::io_error, EBADF};
  bool anything = false;
  std::uint64_t newest = 0;
  for (std::size_t file = 0; file < files; ++file) {
    std::uint64_t number = 0;
    std::size_t size = 0;
    const bool whole = load(file, number, size, anything);
    numbers_[file] = whole ? number : 0;
    if (!whole || number <= newest) continue;
    if (size > content.size()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(size)};
    newest = number;
    bytes = size;
    std::copy_n(block_.begin() + sizeof(Head), size, content.begin());
  }
  known_ = true;
  if (newest != 0) return {};
  return anything ? StatusCode::record_damaged : StatusCode::not_found;
}

Status FileNonvolatile::write(std::span<const std::uint8_t> content) {
  static_assert(max_nonvolatile_bytes <= block_bytes - sizeof(Head));
  if (content.size() > max_nonvolatile_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(content.size()), max_nonvolatile_bytes};
  }
  if (files_[0] < 0) return {StatusCode::io_error, EBADF};
  if (!known_) {
    // New numbers must exceed those that exist already.
    bool anything = false;
    for (std::size_t file = 0; file < files; ++file) {
      std::size_t size = 0;
      if (!load(file, numbers_[file], size, anything)) numbers_[file] = 0;
    }
    known_ = true;
  }
  const std::size_t file = numbers_[0] <= numbers_[1] ? 0 : 1;
  Head head;
  head.magic = magic;
  head.number = std::max(numbers_[0], numbers_[1]) + 1;
  head.bytes = static_cast<std::uint32_t>(content.size());
  head.file = static_cast<std::uint32_t>(file);
  block_ = {};
  std::copy(content.begin(), content.end(), block_.begin() + sizeof(head));
  std::memcpy(block_.data(), &head, sizeof(head));
  head.crc32 = crc32(std::span<const std::uint8_t>(block_).subspan(sizeof(head.crc32)));
  std::memcpy(block_.data(), &head, sizeof(head));
  // Whatever the result is, the file no longer holds its old content.
  numbers_[file] = 0;
  if (::lseek(files_[file], 0, SEEK_SET) < 0) return failure();
  for (std::size_t copy = 0; copy < copies; ++copy) ILP_TRY(write_all(files_[file], block_));
  if (::fdatasync(files_[file]) != 0) return failure();
  numbers_[file] = head.number;
  return {};
}

}  // namespace ilp
