#include "hal/camera/y4m/y4m_camera.hpp"

#include <cstring>

#include "fsw/base/text.hpp"
#include "hal/posix/number.hpp"

namespace ilp {
namespace {

constexpr std::int64_t max_seconds = 9'000'000'000;  // of mission time in 64 bits of nanoseconds

bool begins_with(const char* text, const char* prefix) {
  return std::strncmp(text, prefix, std::strlen(prefix)) == 0;
}

/// Bytes of both chroma planes, or false for a sampling that is not 8 bit or unknown.
bool chroma_plane_bytes(const char* sampling, std::size_t width, std::size_t height, std::size_t& bytes) {
  const std::size_t half_width = (width + 1) / 2;
  const std::size_t half_height = (height + 1) / 2;
  const auto is = [sampling](const char* name) { return std::strcmp(sampling, name) == 0; };
  if (is("420") || is("420jpeg") || is("420mpeg2") || is("420paldv")) {
    bytes = 2 * half_width * half_height;
  } else if (is("422")) {
    bytes = 2 * half_width * height;
  } else if (is("444")) {
    bytes = 2 * width * height;
  } else if (is("411")) {
    bytes = 2 * ((width + 3) / 4) * height;
  } else if (is("mono")) {
    bytes = 0;
  } else {
    return false;
  }
  return true;
}

}  // namespace

Status Y4mCamera::read_header_line() {
  std::size_t size = 0;
  for (std::size_t i = 0; i < sizeof(line_); ++i) {
    std::uint8_t byte = 0;
    const Status status = reader_.next(byte);
    if (status.is(StatusCode::end_of_stream) && size > 0) return {StatusCode::truncated, status.a};
    ILP_TRY(status);
    if (byte == '\n') {
      line_[size] = 0;
      return {};
    }
    line_[size++] = static_cast<char>(byte);
  }
  return {StatusCode::parse_error, static_cast<std::int64_t>(sizeof(line_))};
}

Status Y4mCamera::parse_header() {
  if (!begins_with(line_, "YUV4MPEG2 ")) return {StatusCode::parse_error, 0};
  width_ = 0;
  height_ = 0;
  rate_numerator_ = 0;
  rate_denominator_ = 0;
  char sampling[16] = "420";
  const char* text = line_ + 10;
  // Every turn consumes a character of the line.
  while (*text != 0) {
    const char tag = *text++;
    std::int64_t value = 0;
    if (tag == 'W' && read_digits(text, 9, value)) width_ = static_cast<std::int32_t>(value);
    if (tag == 'H' && read_digits(text, 9, value)) height_ = static_cast<std::int32_t>(value);
    if (tag == 'F' && read_digits(text, 9, value) && *text == ':') {
      rate_numerator_ = value;
      ++text;
      if (read_digits(text, 9, value)) rate_denominator_ = value;
    }
    if (tag == 'C') {
      std::size_t size = 0;
      for (; *text != 0 && *text != ' ' && size + 1 < sizeof(sampling); ++text) sampling[size++] = *text;
      sampling[size] = 0;
    }
    while (*text != 0 && *text != ' ') ++text;
    while (*text == ' ') ++text;
  }
  if (width_ <= 0 || height_ <= 0) return {StatusCode::parse_error, 0};
  if (width_ > limits::max_image_width || height_ > limits::max_image_height) {
    return {StatusCode::image_too_large, width_, height_};
  }
  if (rate_numerator_ <= 0 || rate_denominator_ <= 0) return {StatusCode::unsupported_format, 4};
  if (!chroma_plane_bytes(sampling, static_cast<std::size_t>(width_), static_cast<std::size_t>(height_),
                          chroma_bytes_)) {
    return {StatusCode::unsupported_format, 3};
  }
  return {};
}

Status Y4mCamera::open(int file) {
  reader_.attach(file);
  const Status status = read_header_line();
  if (status.is(StatusCode::end_of_stream)) return {StatusCode::truncated, status.a};
  ILP_TRY(status);
  ILP_TRY(parse_header());
  sequence_ = 0;
  ended_ = false;
  return {};
}

Status Y4mCamera::due_time(TimeNs& due) const {
  // In two steps, exact: the product of all three does not fit 64 bits.
  const std::int64_t ticks = sequence_ * rate_denominator_;
  const std::int64_t seconds = ticks / rate_numerator_;
  if (seconds > max_seconds) return {StatusCode::unsupported_format, 4};
  due = seconds * ns_per_s + ticks % rate_numerator_ * ns_per_s / rate_numerator_;
  return {};
}

Status Y4mCamera::skip(std::size_t bytes) {
  std::uint8_t sink[1024];
  while (bytes > 0) {
    const std::size_t size = bytes < sizeof(sink) ? bytes : sizeof(sink);
    ILP_TRY(reader_.fill({sink, size}));
    bytes -= size;
  }
  return {};
}

Status Y4mCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (ended_) return {StatusCode::end_of_stream, sequence_};
  TimeNs due = 0;
  const Status timed = due_time(due);
  if (!timed.ok()) ended_ = true;
  ILP_TRY(timed);
  if (due > now) return StatusCode::not_ready;
  frame = {};
  frame.time_ns = due;
  frame.sequence = sequence_ + 1;
  FixedText<64> name;
  name.add("frame-").add(frame.sequence, 6);
  copy_text(frame.name, name.c_str());

  Status status = read_header_line();
  if (status.is(StatusCode::end_of_stream)) {
    ended_ = true;
    return {StatusCode::end_of_stream, sequence_};
  }
  if (status.ok() && !begins_with(line_, "FRAME")) status = {StatusCode::parse_error, sequence_};
  if (status.ok()) status = image.resize(width_, height_);
  if (status.ok()) {
    const ImageView<std::uint8_t> view = image.view();
    status = reader_.fill({view.data, view.area()});
  }
  if (status.ok()) status = skip(chroma_bytes_);
  if (!status.ok()) ended_ = true;
  ++sequence_;
  return status;
}

}  // namespace ilp
