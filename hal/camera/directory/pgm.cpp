#include "hal/camera/directory/pgm.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <span>

#include "fsw/base/status_values.hpp"
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
  if (magic[0] != 'P' || magic[1] != '5') return not_supported(FormatFault::not_pgm);
  std::int32_t maximum = 0;
  ILP_TRY(read_number(reader, width));
  ILP_TRY(read_number(reader, height));
  ILP_TRY(read_number(reader, maximum));
  if (maximum != 255) return not_supported(FormatFault::pgm_depth);
  return width == 0 || height == 0 ? Status{StatusCode::parse_error, 0} : Status{};
}

Status read_pixels(BufferedReader& reader, std::int32_t width, std::int32_t height, FrameImage& image) {
  ILP_TRY(image.resize(width, height));
  const ImageView<std::uint8_t> view = image.view();
  return reader.fill({view.data, view.area()});
}

/// Row by row: a large picture does not fit the memory.
Status read_rows(BufferedReader& reader, std::int32_t width, std::int32_t height, RowReducer& rows) {
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_sensor_side)> pixels;
  const std::span row(pixels.data(), static_cast<std::size_t>(width));
  for (std::int32_t y = 0; y < height; ++y) {
    ILP_TRY(reader.fill(row));
    rows.add(row);
  }
  return {};
}

Status read_picture(BufferedReader& reader, std::int32_t width, std::int32_t height, RowReducer& rows,
                    FrameImage& image) {
  std::int32_t w = 0, h = 0;
  ILP_TRY(read_header(reader, w, h));
  Reduction reduction;
  ILP_TRY(find_reduction(w, h, reduction));
  if (width != 0 && (w != width || h != height)) return {StatusCode::image_size_changed, w, h};
  if (reduction.changes_nothing()) return read_pixels(reader, w, h, image);
  ILP_TRY(image.resize(reduction.width, reduction.height));
  rows.begin(reduction, image.view());
  return read_rows(reader, w, h, rows);
}

Status open_file(const char* path, int& file) {
  file = open(path, O_RDONLY | O_CLOEXEC);
  if (file >= 0) return {};
  return errno == ENOENT ? Status{StatusCode::not_found} : Status{StatusCode::io_error, errno};
}

/// A file that ends within its header or its pixels.
Status file_status(const Status& status) {
  return status.is(StatusCode::end_of_stream) ? Status{StatusCode::truncated, status.a} : status;
}

/// Without `image`, only the header is read.
Status read_file(const char* path, std::int32_t& width, std::int32_t& height, FrameImage* image) {
  int file = -1;
  ILP_TRY(open_file(path, file));
  BufferedReader reader;
  reader.attach(file);
  Status status = read_header(reader, width, height);
  if (status.ok() && image != nullptr) status = read_pixels(reader, width, height, *image);
  close(file);
  return file_status(status);
}

}  // namespace

Status read_pgm(const char* path, FrameImage& image) {
  std::int32_t width = 0;
  std::int32_t height = 0;
  return read_file(path, width, height, &image);
}

Status read_large_pgm(const char* path, std::int32_t width, std::int32_t height, RowReducer& rows, FrameImage& image) {
  int file = -1;
  ILP_TRY(open_file(path, file));
  BufferedReader reader;
  reader.attach(file);
  const Status status = read_picture(reader, width, height, rows, image);
  close(file);
  return file_status(status);
}

Status read_pgm_size(const char* path, std::int32_t& width, std::int32_t& height) {
  return read_file(path, width, height, nullptr);
}

}  // namespace ilp
