#include "hal/camera/directory/directory_camera.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <limits>

#include "fsw/base/text.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "hal/posix/number.hpp"

namespace ilp {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

void skip_blanks(const char*& text) {
  while (is_blank(*text)) ++text;  // bound: the text; its end is no blank
}

bool at_end_of_word(const char* text) {
  return *text == 0 || is_blank(*text);
}

bool read_integer(const char*& text, std::int64_t& value) {
  const bool negative = *text == '-';
  if (negative) ++text;
  if (!read_digits(text, 18, value)) return false;
  if (negative) value = -value;
  return at_end_of_word(text);
}

bool read_decimal(const char*& text, double& value) {
  const bool negative = *text == '-';
  if (negative) ++text;
  std::int64_t whole = 0;
  if (!read_digits(text, 15, whole)) return false;
  double number = static_cast<double>(whole);
  if (*text == '.') {
    ++text;
    double unit = 1;
    // Digits beyond the twelfth are below any altimeter's resolution.
    double fraction = 0;
    for (int digits = 0; *text >= '0' && *text <= '9'; ++text, ++digits) {
      if (digits >= 12) continue;
      fraction = fraction * 10 + (*text - '0');
      unit *= 10;
    }
    number += fraction / unit;
  }
  value = negative ? -number : number;
  return at_end_of_word(text);
}

}  // namespace

DirectoryCamera::~DirectoryCamera() {
  if (file_ >= 0) close(file_);
}

Status DirectoryCamera::open(const char* index, std::int32_t width, std::int32_t height, DecodeImage decode) {
  if (file_ >= 0) close(file_);
  file_ = -1;
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
  line_number_ = 0;
  sequence_ = 0;
  latest_ns_ = std::numeric_limits<TimeNs>::min();
  waiting_ = false;
  ended_ = false;
  return {};
}

Status DirectoryCamera::find_size(const char* index, std::int32_t& width, std::int32_t& height) {
  ILP_TRY(open(index, 0, 0, nullptr));
  Status found = StatusCode::not_found;
  // Bounded by the lines of the index; a damaged image or line is passed over.
  while (!found.ok() && !ended_) {
    const Status line = find_next();
    if (line.ok()) found = read_pgm_size(path_, width, height);
  }
  close(file_);
  file_ = -1;
  return found.ok() ? found : Status{StatusCode::not_found, line_number_};
}

Status DirectoryCamera::read_line() {
  ++line_number_;
  std::size_t size = 0;
  const Status status = reader_.line(line_, size);
  return status.is(StatusCode::parse_error) ? Status{StatusCode::parse_error, line_number_} : status;
}

Status DirectoryCamera::parse_line() {
  const char* text = line_;
  skip_blanks(text);
  if (*text == 0 || *text == '#') return StatusCode::not_ready;
  next_ = {};
  next_.sequence = ++sequence_;
  if (!read_integer(text, next_.time_ns)) return {StatusCode::parse_error, line_number_};
  skip_blanks(text);
  FixedText<limits::max_path_bytes> path;
  if (*text != '/') path.add(folder_);
  const std::size_t name_begin = path.size();
  for (; *text != 0 && !is_blank(*text); ++text) path.add(*text);
  if (path.overflow() || path.size() == name_begin) return {StatusCode::parse_error, line_number_};
  copy_text(path_, path.c_str());
  copy_text(next_.name, base_name(path_));
  skip_blanks(text);
  if (*text != 0 && *text != '#') {
    if (!read_decimal(text, next_.altitude)) return {StatusCode::parse_error, line_number_};
    skip_blanks(text);
    if (*text != 0 && *text != '#') return {StatusCode::parse_error, line_number_};
  }
  return {};
}

Status DirectoryCamera::find_next() {
  Status status = StatusCode::not_ready;
  // Bounded by the comments of the index.
  while (status.is(StatusCode::not_ready)) {
    status = read_line();
    if (status.ok()) {
      status = parse_line();
    } else if (status.is(StatusCode::parse_error)) {
      next_ = {};
      next_.sequence = ++sequence_;
    } else {
      ended_ = true;
    }
  }
  return status;
}

Status DirectoryCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (!waiting_) {
    if (ended_ || file_ < 0) return {StatusCode::end_of_stream, sequence_};
    const Status status = find_next();
    if (status.is(StatusCode::end_of_stream)) return {StatusCode::end_of_stream, sequence_};
    frame = next_;
    ILP_TRY(status);
    waiting_ = true;
  }
  // A frame from before its predecessor is already due.
  if (next_.time_ns > now) return StatusCode::not_ready;
  waiting_ = false;
  frame = next_;
  if (next_.time_ns <= latest_ns_) return {StatusCode::time_not_monotonic, next_.sequence, latest_ns_ - next_.time_ns};
  latest_ns_ = next_.time_ns;
  const Status decoded =
      decode_ != nullptr ? decode_(path_, image) : read_large_pgm(path_, width_, height_, rows_, image);
  if (decoded.is(StatusCode::not_found)) return {StatusCode::not_found, frame.sequence};
  ILP_TRY(decoded);
  if (image.width() > limits::max_image_width || image.height() > limits::max_image_height) {
    return {StatusCode::image_too_large, image.width(), image.height()};
  }
  if (decode_ != nullptr && width_ != 0 && (image.width() != width_ || image.height() != height_)) {
    return {StatusCode::image_size_changed, image.width(), image.height()};
  }
  return {};
}

}  // namespace ilp
