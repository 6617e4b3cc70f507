#include "hal/link/outbox/outbox_link.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/text.hpp"
#include "hal/posix/file.hpp"
#include "hal/posix/number.hpp"

namespace ilp {
namespace {

using Path = FixedText<limits::max_path_bytes>;

Status errno_status() {
  return {StatusCode::io_error, errno};
}

bool is_plain_name(const char* name) {
  if (name == nullptr || name[0] == 0 || name[0] == '.') return false;
  for (const char* c = name; *c != 0; ++c) {
    if (*c == '/') return false;
  }
  return true;
}

Path join(const char* folder, const char* name, const char* suffix) {
  Path path;
  path.add(folder).add('/').add(name).add(suffix);
  return path;
}

/// Largest content of an acknowledgement: "4294967295 4294967295\n" and a terminator.
constexpr std::size_t max_acknowledgement_bytes = 24;

/// `not_ready` for the beginning of an acknowledgement, which the ground may still be writing.
Status parse_acknowledgement(const char* text, std::uint32_t& bytes, std::uint32_t& crc32) {
  std::int64_t numbers[2] = {};
  const char ends[2] = {' ', '\n'};
  for (int i = 0; i < 2; ++i) {
    if (*text == 0) return StatusCode::not_ready;
    if (!read_digits(text, 10, numbers[i]) || numbers[i] > 0xFFFFFFFF) return StatusCode::parse_error;
    if (*text == 0) return StatusCode::not_ready;
    if (*text++ != ends[i]) return StatusCode::parse_error;
  }
  if (*text != 0) return StatusCode::parse_error;
  bytes = static_cast<std::uint32_t>(numbers[0]);
  crc32 = static_cast<std::uint32_t>(numbers[1]);
  return {};
}

}  // namespace

OutboxLink::~OutboxLink() {
  abandon();
}

Status OutboxLink::open(const char* outbox, const char* acknowledgements) {
  abandon();
  for (const char* folder : {outbox, acknowledgements}) {
    if (strnlen(folder, limits::max_path_bytes) == limits::max_path_bytes) {
      return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(limits::max_path_bytes)};
    }
    struct stat info {};
    if (stat(folder, &info) != 0) return errno_status();
    if (!S_ISDIR(info.st_mode)) return {StatusCode::io_error, ENOTDIR};
  }
  copy_text(outbox_, outbox);
  copy_text(acknowledgements_, acknowledgements);
  return {};
}

void OutboxLink::abandon() {
  if (file_ < 0) return;
  close(file_);
  file_ = -1;
  static_cast<void>(unlink(join(outbox_, name_, ".part").c_str()));
}

Status OutboxLink::begin_file(const char* name) {
  abandon();
  if (outbox_[0] == 0 || !is_plain_name(name)) return out_of_range(Argument::file_name);
  const Path path = join(outbox_, name, ".part");
  if (path.overflow()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(path.size())};
  file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file_ < 0) return errno_status();
  copy_text(name_, name);
  return {};
}

Status OutboxLink::write(std::span<const std::uint8_t> bytes) {
  if (file_ < 0) return out_of_range(Argument::open_file);
  const Status status = write_all(file_, bytes);
  if (!status.ok()) abandon();
  return status;
}

Status OutboxLink::end_file() {
  if (file_ < 0) return out_of_range(Argument::open_file);
  const Path part = join(outbox_, name_, ".part");
  const Path whole = join(outbox_, name_, "");
  if (fsync(file_) != 0 || rename(part.c_str(), whole.c_str()) != 0) {
    const Status status = errno_status();
    abandon();
    return status;
  }
  close(file_);
  file_ = -1;
  return synchronise_folder_of(whole.c_str());
}

Status OutboxLink::acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) {
  if (acknowledgements_[0] == 0 || !is_plain_name(name)) return out_of_range(Argument::file_name);
  const Path path = join(acknowledgements_, name, ".ack");
  if (path.overflow()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(path.size())};
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_ready} : errno_status();
  std::uint8_t content[max_acknowledgement_bytes] = {};
  std::size_t size = 0;
  const Status status = read_some(file, {content, sizeof(content) - 1}, size);
  close(file);
  ILP_TRY(status);
  const auto* text = reinterpret_cast<const char*>(content);
  if (std::strlen(text) != size) return StatusCode::parse_error;
  return parse_acknowledgement(text, bytes, crc32);
}

}  // namespace ilp
