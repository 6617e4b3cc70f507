#include "hal/camera/picture/reduction.hpp"

#include <algorithm>
#include <cstring>

namespace ilp {
namespace {

constexpr std::int32_t least_tenths = 9;

bool enough(std::int32_t kept, std::int32_t side) {
  return 10 * kept >= least_tenths * side;
}

double reduced_coordinate(double x, std::int32_t cut, std::int32_t factor) {
  return (x - cut + 0.5) / factor - 0.5;
}

void add_bins(const std::uint8_t* pixels, std::int32_t factor, std::int32_t width, std::uint32_t* sums) {
  for (std::int32_t x = 0; x < width; ++x) {
    std::uint32_t sum = 0;
    for (std::int32_t i = 0; i < factor; ++i) sum += *pixels++;
    sums[x] += sum;
  }
}

}  // namespace

Status find_reduction(std::int32_t width, std::int32_t height, Reduction& reduction) {
  reduction = {};
  const Status refused{StatusCode::image_too_large, width, height};
  if (width < 1 || height < 1 || width > limits::max_sensor_side || height > limits::max_sensor_side) return refused;
  std::int32_t factor = 0, w = 0, h = 0;
  // Ends at the latest where the whole picture fits.
  do {
    ++factor;
    w = std::min(width / factor, limits::max_image_width);
    h = std::min(height / factor, limits::max_image_height);
    // bound: the picture's sides; `factor` grows
  } while ((!enough(w * factor, width) || !enough(h * factor, height)) && w > 0 && h > 0);
  if (w == 0 || h == 0) return refused;
  reduction = {factor, (width - w * factor) / 2, (height - h * factor) / 2, w, h};
  return {};
}

CameraModel reduced_camera(const CameraModel& camera, const Reduction& reduction) {
  CameraModel reduced = camera;
  reduced.width = reduction.width;
  reduced.height = reduction.height;
  reduced.fx = camera.fx / reduction.factor;
  reduced.fy = camera.fy / reduction.factor;
  reduced.cx = reduced_coordinate(camera.cx, reduction.left, reduction.factor);
  reduced.cy = reduced_coordinate(camera.cy, reduction.top, reduction.factor);
  return reduced;
}

void RowReducer::begin(const Reduction& reduction, MutableGrayView image) {
  reduction_ = reduction;
  image_ = image;
  row_ = 0;
}

bool RowReducer::wants_row() const {
  return row_ >= reduction_.top && row_ < reduction_.top + reduction_.height * reduction_.factor;
}

void RowReducer::add(std::span<const std::uint8_t> row) {
  const bool wanted = wants_row();
  const std::int32_t inside = row_++ - reduction_.top;
  if (!wanted) return;
  const std::uint8_t* const pixels = row.data() + reduction_.left;
  const std::int32_t factor = reduction_.factor;
  if (factor == 1) {
    std::memcpy(image_.row(inside), pixels, static_cast<std::size_t>(image_.width));
    return;
  }
  const std::int32_t part = inside % factor;
  if (part == 0) std::fill_n(sums_.begin(), image_.width, 0U);
  add_bins(pixels, factor, image_.width, sums_.data());
  if (part + 1 < factor) return;
  const std::uint32_t count = static_cast<std::uint32_t>(factor) * static_cast<std::uint32_t>(factor);
  std::uint8_t* const to = image_.row(inside / factor);
  for (std::int32_t x = 0; x < image_.width; ++x) {
    to[x] = static_cast<std::uint8_t>((sums_[static_cast<std::size_t>(x)] + count / 2) / count);
  }
}

}  // namespace ilp
