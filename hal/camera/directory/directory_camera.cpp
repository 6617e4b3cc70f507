#include "hal/camera/directory/directory_camera.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <limits>

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

void skip_blanks(const char*& text) {
  while (is_blank(*text)) ++text;
}

bool read_integer(const char*& text, std::int64_t& value) {
  const bool negative = *text == '-';
  if (negative) ++text;
  std::int64_t number = 0;
  int digits = 0;
  for (; *text >= '0' && *text <= '9' && digits < 18; ++text, ++digits) number = number * 10 + (*text - '0');
  value = negative ? -number : number;
  return digits > 0 && (*text == 0 || is_blank(*text));
}

bool read_decimal(const char*& text, double& value) {
  const bool negative = *text == '-';
  if (negative) ++text;
  double number = 0;
  double unit = 1;
  int digits = 0;
  for (; *text >= '0' && *text <= '9' && digits < 15; ++text, ++digits) number = number * 10 + (*text - '0');
  if (*text == '.') {
    ++text;
    for (; *text >= '0' && *text <= '9' && digits < 18; ++text, ++digits) {
      number = number * 10 + (*text - '0');
      unit *= 10;
    }
  }
  value = (negative ? -number : number) / unit;
  return digits > 0 && (*text == 0 || is_blank(*text));
}

}  // namespace

DirectoryCamera::~DirectoryCamera() {
  if (file_ >= 0) close(file_);
}

Status DirectoryCamera::open(const char* index, std::int32_t width, std::int32_t height, DecodeImage decode) {
  FixedText<limits::max_path_bytes> folder;
  for (const char* c = index; c != base_name(index); ++c) folder.add(*c);
  if (folder.overflow()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(limits::max_path_bytes)};
  file_ = ::open(index, O_RDONLY | O_CLOEXEC);
  if (file_ < 0) return errno == ENOENT ? Status{StatusCode::not_found} : Status{StatusCode::io_error, errno};
  reader_.attach(file_);
  copy_text(folder_, folder.c_str());
  width_ = width;
  height_ = height;
  decode_ = decode;
  return {};
}

Status DirectoryCamera::read_line() {
  std::size_t size = 0;
  bool any = false;
  bool too_long = false;
  ++line_number_;
  // Bounded by the file: every turn consumes a byte of it.
  for (;;) {
    std::uint8_t byte = 0;
    const Status status = reader_.next(byte);
    if (status.is(StatusCode::end_of_stream)) {
      if (!any) return status;
      break;
    }
    ILP_TRY(status);
    any = true;
    if (byte == '\n') break;
    if (size + 1 < sizeof(line_)) {
      line_[size++] = static_cast<char>(byte);
    } else {
      too_long = true;
    }
  }
  line_[size] = 0;
  return too_long ? Status{StatusCode::parse_error, line_number_} : Status{};
}

Status DirectoryCamera::parse_line() {
  const char* text = line_;
  skip_blanks(text);
  if (*text == 0 || *text == '#') return StatusCode::not_ready;
  next_ = {};
  if (!read_integer(text, next_.time_ns)) return {StatusCode::parse_error, line_number_};
  skip_blanks(text);
  FixedText<limits::max_path_bytes> path;
  if (*text != '/') path.add(folder_);
  const std::size_t name_begin = path.size();
  for (; *text != 0 && !is_blank(*text); ++text) path.add(*text);
  if (path.overflow() || path.size() == name_begin) return {StatusCode::parse_error, line_number_};
  skip_blanks(text);
  if (*text != 0 && !read_decimal(text, next_.altitude)) return {StatusCode::parse_error, line_number_};
  copy_text(path_, path.c_str());
  copy_text(next_.name, base_name(path_));
  next_.sequence = ++sequence_;
  return {};
}

Status DirectoryCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (ended_ || file_ < 0) return {StatusCode::end_of_stream, sequence_};
  // Bounded by the comments of the index.
  while (!waiting_) {
    Status status = read_line();
    if (status.is(StatusCode::end_of_stream)) {
      ended_ = true;
      return {StatusCode::end_of_stream, sequence_};
    }
    if (status.ok()) status = parse_line();
    if (status.is(StatusCode::not_ready)) continue;
    ILP_TRY(status);
    waiting_ = true;
  }
  if (next_.time_ns > now) return StatusCode::not_ready;
  waiting_ = false;
  frame = next_;
  ILP_TRY(decode_(path_, image));
  if (width_ != 0 && (image.width() != width_ || image.height() != height_)) {
    return {StatusCode::image_size_changed, image.width(), image.height()};
  }
  return {};
}

}  // namespace ilp
