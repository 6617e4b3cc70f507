#include "hal/link/outbox/outbox_link.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "fsw/base/text.hpp"
#include "hal/posix/file.hpp"

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

bool read_number(const char*& text, const char* end, std::uint32_t& value) {
  std::uint64_t number = 0;
  int digits = 0;
  for (; text != end && *text >= '0' && *text <= '9' && digits < 11; ++text, ++digits) {
    number = number * 10 + static_cast<std::uint64_t>(*text - '0');
  }
  value = static_cast<std::uint32_t>(number);
  return digits > 0 && number <= 0xFFFFFFFFU;
}

}  // namespace

OutboxLink::~OutboxLink() {
  abandon();
}

Status OutboxLink::open(const char* outbox, const char* acknowledgements) {
  for (const char* folder : {outbox, acknowledgements}) {
    struct stat info {};
    if (stat(folder, &info) != 0) return errno_status();
    if (!S_ISDIR(info.st_mode)) return {StatusCode::io_error, ENOTDIR};
  }
  copy_text(outbox_, outbox);
  copy_text(acknowledgements_, acknowledgements);
  return {};
}

void OutboxLink::abandon() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

Status OutboxLink::begin_file(const char* name) {
  abandon();
  if (!is_plain_name(name)) return {StatusCode::invalid_argument, 1};
  const Path path = join(outbox_, name, ".part");
  if (path.overflow()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(path.size())};
  file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file_ < 0) return errno_status();
  copy_text(name_, name);
  return {};
}

Status OutboxLink::write(std::span<const std::uint8_t> bytes) {
  if (file_ < 0) return {StatusCode::invalid_argument, 2};
  const Status status = write_all(file_, bytes);
  if (!status.ok()) abandon();
  return status;
}

Status OutboxLink::end_file() {
  if (file_ < 0) return {StatusCode::invalid_argument, 2};
  const bool synchronised = fsync(file_) == 0;
  const Status status = synchronised ? Status{} : errno_status();
  abandon();
  ILP_TRY(status);
  if (rename(join(outbox_, name_, ".part").c_str(), join(outbox_, name_, "").c_str()) != 0) return errno_status();
  return {};
}

Status OutboxLink::acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) {
  if (!is_plain_name(name)) return {StatusCode::invalid_argument, 1};
  const Path path = join(acknowledgements_, name, ".ack");
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_ready} : errno_status();
  std::uint8_t content[32] = {};
  std::size_t size = 0;
  const Status status = read_some(file, content, size);
  close(file);
  ILP_TRY(status);
  const char* text = reinterpret_cast<const char*>(content);
  const char* end = text + size;
  // The ground may still be writing: what does not end with a newline is not there yet.
  if (size == 0) return StatusCode::not_ready;
  if (!read_number(text, end, bytes) || text == end || *text++ != ' ') return {StatusCode::parse_error, 1};
  if (!read_number(text, end, crc32)) return {StatusCode::parse_error, 1};
  return text != end && *text == '\n' ? Status{} : Status{StatusCode::not_ready};
}

}  // namespace ilp
