#include "hal/camera/y4m/y4m_camera.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/status_values.hpp"
#include "fsw/base/text.hpp"
#include "hal/posix/number.hpp"

namespace ilp {
namespace {

// A live stream may take this long to send its header, and this long for the bytes that one call asks for.
constexpr int header_waits = 100, header_wait_ms = 100;
constexpr int slice_waits = 4, slice_wait_ms = 5;
constexpr std::size_t longest_comments = 65536;
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

/// 420p10 and others, mono10, mono16; 8 without a number.
std::int32_t bits_of(const char* sampling) {
  const char* text = sampling;
  if (begins_with(text, "mono")) {
    text += 4;
  } else {
    while (*text >= '0' && *text <= '9') ++text;  // bound: the text
    if (*text++ != 'p') return 8;
  }
  std::int64_t bits = 0;
  return read_digits(text, 2, bits) ? static_cast<std::int32_t>(bits) : 8;
}

}  // namespace

/// Goes on where an earlier call was left with `not_ready`. Comments (tags that begin with X) may be long and are
/// passed over.
Status Y4mCamera::read_line() {
  while (line_size_ < sizeof(line_) && skipped_ < longest_comments) {  // bound: each turn raises one of both
    std::uint8_t byte = 0;
    const Status status = reader_.next(byte);
    if (status.is(StatusCode::end_of_stream) && line_size_ > 0) return {StatusCode::truncated, status.a};
    ILP_TRY(status);
    if (byte == '\n') {
      line_[line_size_] = 0;
      line_size_ = skipped_ = 0;
      in_comment_ = false;
      return {};
    }
    if (byte == 'X' && line_size_ > 0 && line_[line_size_ - 1] == ' ') in_comment_ = true;
    if (byte == ' ') in_comment_ = false;
    if (in_comment_) {
      ++skipped_;
    } else {
      line_[line_size_++] = static_cast<char>(byte);
    }
  }
  return {StatusCode::parse_error, static_cast<std::int64_t>(line_size_ + skipped_)};
}

Status Y4mCamera::parse_header() {
  if (!begins_with(line_, "YUV4MPEG2 ")) return {StatusCode::parse_error, 0};
  width_ = 0;
  height_ = 0;
  rate_numerator_ = 0;
  rate_denominator_ = 0;
  interlaced_ = false;
  aspect_width_ = aspect_height_ = 0;
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
    // t, b and m: lines of the upper or lower field first, or mixed.
    if (tag == 'I') interlaced_ = *text == 't' || *text == 'b' || *text == 'm';
    if (tag == 'A' && read_digits(text, 9, value) && *text == ':') {
      aspect_width_ = value;
      ++text;
      if (read_digits(text, 9, value)) aspect_height_ = value;
    }
    if (tag == 'C') {
      std::size_t size = 0;
      for (; *text != 0 && *text != ' ' && size + 1 < sizeof(sampling); ++text) sampling[size++] = *text;
      sampling[size] = 0;
    }
    while (*text != 0 && *text != ' ') ++text;
    while (*text == ' ') ++text;  // bound: the text; its end is no blank
  }
  if (width_ <= 0 || height_ <= 0) return {StatusCode::parse_error, 0};
  ILP_TRY(find_reduction(width_, height_, reduction_));
  bits_ = bits_of(sampling);
  if (bits_ != 8) return not_supported(FormatFault::y4m_sampling);
  if (rate_numerator_ <= 0 || rate_denominator_ <= 0) {
    rate_numerator_ = rate_.frames;
    rate_denominator_ = rate_.seconds;
  }
  if (rate_numerator_ <= 0 || rate_denominator_ <= 0) return not_supported(FormatFault::y4m_rate);
  if (!chroma_plane_bytes(sampling, static_cast<std::size_t>(width_), static_cast<std::size_t>(height_),
                          chroma_bytes_)) {
    return not_supported(FormatFault::y4m_sampling);
  }
  return {};
}

Status Y4mCamera::open(int file, const Y4mArrival& arrival) {
  reader_.attach(file);
  ended_ = true;
  live_ = arrival.live;
  rate_ = arrival.rate;
  broken_ = {};
  if (live_) reader_.allow_waits(header_waits, header_wait_ms);
  line_size_ = skipped_ = 0;
  in_comment_ = false;
  const Status status = read_line();
  if (status.is(StatusCode::end_of_stream)) return {StatusCode::truncated, status.a};
  ILP_TRY(status);
  ILP_TRY(parse_header());
  ILP_TRY(luma_.resize(reduction_.width, reduction_.height));
  sequence_ = 0;
  begun_ = !live_;
  begin_ns_ = 0;
  part_ = Part::line;
  got_ = 0;
  ended_ = false;
  return {};
}

Status Y4mCamera::due_time(TimeNs& due) const {
  // In two steps, exact: the product of all three does not fit 64 bits.
  const std::int64_t ticks = sequence_ * rate_denominator_;
  const std::int64_t seconds = ticks / rate_numerator_ + begin_ns_ / ns_per_s;
  if (seconds > max_seconds) return not_supported(FormatFault::y4m_rate);
  due = seconds * ns_per_s + begin_ns_ % ns_per_s + ticks % rate_numerator_ * ns_per_s / rate_numerator_;
  return {};
}

Status Y4mCamera::read_luma() {
  if (reduction_.changes_nothing()) {
    const ImageView<std::uint8_t> view = luma_.view();
    return reader_.fill({view.data, view.area()}, got_);
  }
  const std::span row(row_.data(), static_cast<std::size_t>(width_));
  while (rows_.next_row() < height_) {  // bound: one row a turn
    ILP_TRY(reader_.fill(row, got_));
    rows_.add(row);
    got_ = 0;
  }
  return {};
}

Status Y4mCamera::skip_chroma() {
  std::uint8_t sink[1024];
  while (got_ < chroma_bytes_) {
    const std::size_t size = std::min(chroma_bytes_ - got_, sizeof(sink));
    std::size_t got = 0;
    const Status status = reader_.fill({sink, size}, got);
    got_ += got;
    ILP_TRY(status);
  }
  return {};
}

Status Y4mCamera::read_frame(TimeNs now) {
  if (live_) reader_.allow_waits(slice_waits, slice_wait_ms);
  if (part_ == Part::line) {
    ILP_TRY(read_line());
    if (!begins_with(line_, "FRAME")) return {StatusCode::parse_error, sequence_};
    if (!begun_) begin_ns_ = now;
    begun_ = true;
    part_ = Part::luma;
    rows_.begin(reduction_, luma_.view());
    got_ = 0;
  }
  if (part_ == Part::luma) {
    ILP_TRY(read_luma());
    part_ = Part::chroma;
    got_ = 0;
  }
  ILP_TRY(skip_chroma());
  part_ = Part::line;
  return {};
}

Status Y4mCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (ended_) return {StatusCode::end_of_stream, sequence_};
  TimeNs due = 0;
  Status status = due_time(due);
  if (status.ok() && begun_ && due > now) return StatusCode::not_ready;
  if (status.ok()) status = read_frame(now);
  if (status.is(StatusCode::not_ready)) return status;
  if (status.ok()) status = due_time(due);
  if (status.is(StatusCode::end_of_stream)) status.a = sequence_;
  if (!status.ok()) ended_ = true;
  if (status.is(StatusCode::end_of_stream)) return status;
  broken_ = status;
  frame = {};
  frame.time_ns = due;
  frame.sequence = ++sequence_;
  FixedText<64> name;
  name.add("frame-").add(frame.sequence, 6);
  copy_text(frame.name, name.c_str());
  ILP_TRY(status);
  ILP_TRY(image.resize(reduction_.width, reduction_.height));
  std::copy_n(luma_.view().data, luma_.view().area(), image.view().data);
  return {};
}

}  // namespace ilp
