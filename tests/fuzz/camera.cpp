// Pictures of a camera whose bytes and sizes may be anything.
#include <algorithm>
#include <memory>
#include <vector>

#include "hal/camera/camera.hpp"
#include "hal/camera/jpeg/grey_jpeg.hpp"
#include "hal/camera/v4l2/grey_picture.hpp"
#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {
namespace {

struct Size {
  std::int32_t width, height;
};

/// The size that a JPEG file states, so that changed files are not refused for it; 64 x 64 if there is none of a
/// sensor.
Size stated_size(Octets file) {
  for (std::size_t at = 0; at + 9 <= file.size(); ++at) {
    if (file[at] != 0xFF || (file[at + 1] & 0xF8U) != 0xC0U || file[at + 1] == 0xC4U) continue;
    const Size size{file[at + 7] << 8U | file[at + 8], file[at + 5] << 8U | file[at + 6]};
    Reduction reduction;
    if (find_reduction(size.width, size.height, reduction).ok()) return size;
  }
  return {64, 64};
}

bool is_of_jpeg(const Status& status) {
  return status.is(StatusCode::parse_error) || status.is(StatusCode::truncated) ||
         status.is(StatusCode::unsupported_format) || status.is(StatusCode::image_size_changed) ||
         status.is(StatusCode::arena_exhausted);
}

}  // namespace

void camera_jpeg(Octets input) {
  static const auto image = std::make_unique<FrameImage>();
  static RowReducer rows;
  static std::vector<std::uint8_t> row(static_cast<std::size_t>(limits::max_sensor_side));
  const auto [width, height] = stated_size(input);
  Reduction reduction;
  require(find_reduction(width, height, reduction).ok(), "a size of a sensor");
  require(image->resize(reduction.width, reduction.height).ok(), "the reduced picture fits");
  rows.begin(reduction, image->view());
  const Status status = decode_grey_jpeg(input, width, height, row, rows);
  require(status.ok() ? rows.next_row() == height : is_of_jpeg(status), "all rows, or a reason of the page");
}

void camera_picture(Octets input) {
  static const auto image = std::make_unique<FrameImage>();
  static const auto converter = std::make_unique<GreyConverter>();
  Choices choices(input);
  RawPicture picture{.format = pixel_formats()[choices.byte() % pixel_formats().size()]};
  // Small sizes, of which there are enough bytes, and any.
  const bool small = choices.byte() % 4 != 0;
  picture.width = static_cast<std::int32_t>(small ? choices.byte() : choices.u16());
  picture.height = static_cast<std::int32_t>(small ? choices.byte() : choices.u16());
  const std::size_t row = row_bytes(picture.format, picture.width);
  picture.stride = small ? row + choices.byte() : choices.u32();
  picture.bytes = choices.rest();
  Reduction reduction;
  if (!find_reduction(picture.width, picture.height, reduction).ok()) return;
  require(image->resize(reduction.width, reduction.height).ok(), "the reduced picture fits");
  const Status status = converter->convert(picture, reduction, image->view());
  if (picture.format.packing == Packing::jpeg) return;
  const bool fits = picture.width >= 2 && picture.height >= 2 && picture.stride >= row &&
                    picture.stride <= limits::max_camera_row_bytes &&
                    picture.stride * static_cast<std::size_t>(picture.height - 1) + row <= picture.bytes.size();
  require(status.ok() == fits, "what fits its bytes is converted, and nothing else");
}

}  // namespace ilp::fuzz
