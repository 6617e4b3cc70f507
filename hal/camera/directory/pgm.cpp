#include "hal/camera/directory/pgm.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "hal/posix/buffered_reader.hpp"

namespace ilp {
namespace {

constexpr int max_header_bytes = 4096;

/// Reads the next unsigned number of the header. It skips comments and blanks before it, and consumes one blank after
/// it.
Status read_number(BufferedReader& reader, std::int32_t& value) {
  value = 0;
  bool comment = false;
  bool any = false;
  for (int i = 0; i < max_header_bytes; ++i) {
    std::uint8_t byte = 0;
    ILP_TRY(reader.next(byte));
    if (comment) {
      comment = byte != '\n';
    } else if (byte >= '0' && byte <= '9') {
      value = value * 10 + (byte - '0');
      any = true;
      if (value > 1'000'000) return {StatusCode::parse_error, i};
    } else if (any) {
      return {};
    } else if (byte == '#') {
      comment = true;
    } else if (byte != ' ' && byte != '\t' && byte != '\r' && byte != '\n') {
      return {StatusCode::parse_error, i};
    }
  }
  return {StatusCode::parse_error, max_header_bytes};
}

Status read_header(BufferedReader& reader, std::int32_t& width, std::int32_t& height) {
  std::uint8_t magic[2] = {};
  ILP_TRY(reader.fill(magic));
  if (magic[0] != 'P' || magic[1] != '5') return {StatusCode::unsupported_format, 1};
  std::int32_t maximum = 0;
  ILP_TRY(read_number(reader, width));
  ILP_TRY(read_number(reader, height));
  ILP_TRY(read_number(reader, maximum));
  if (maximum != 255) return {StatusCode::unsupported_format, 2};
  return width == 0 || height == 0 ? Status{StatusCode::parse_error, 0} : Status{};
}

Status read_pixels(BufferedReader& reader, std::int32_t width, std::int32_t height, FrameImage& image) {
  ILP_TRY(image.resize(width, height));
  const ImageView<std::uint8_t> view = image.view();
  return reader.fill({view.data, view.area()});
}

/// Without `image`, only the header is read.
Status read_file(const char* path, std::int32_t& width, std::int32_t& height, FrameImage* image) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_found} : Status{StatusCode::io_error, errno};
  BufferedReader reader;
  reader.attach(file);
  Status status = read_header(reader, width, height);
  if (status.ok() && image != nullptr) status = read_pixels(reader, width, height, *image);
  close(file);
  return status.is(StatusCode::end_of_stream) ? Status{StatusCode::truncated, status.a} : status;
}

}  // namespace

Status read_pgm(const char* path, FrameImage& image) {
  std::int32_t width = 0;
  std::int32_t height = 0;
  return read_file(path, width, height, &image);
}

Status read_pgm_size(const char* path, std::int32_t& width, std::int32_t& height) {
  return read_file(path, width, height, nullptr);
}

}  // namespace ilp
