#include "hal/camera/v4l2/grey_picture.hpp"

#include <algorithm>

#include "hal/camera/jpeg/grey_jpeg.hpp"

namespace ilp {
namespace {

void unpack_words(const std::uint8_t* from, std::int32_t width, std::uint32_t largest, std::uint16_t* to) {
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const std::uint32_t value = from[2 * x] | static_cast<std::uint32_t>(from[2 * x + 1]) << 8U;
    to[x] = static_cast<std::uint16_t>(std::min(value, largest));
  }
}

void unpack_mipi10(const std::uint8_t* from, std::int32_t width, std::uint16_t* to) {
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const std::uint8_t* const group = from + x / 4 * 5;
    const auto low = static_cast<std::uint32_t>(group[4] >> 2 * (x % 4)) & 3U;
    to[x] = static_cast<std::uint16_t>(static_cast<std::uint32_t>(group[x % 4]) << 2U | low);
  }
}

void unpack_mipi12(const std::uint8_t* from, std::int32_t width, std::uint16_t* to) {
  for (std::ptrdiff_t x = 0; x < width; ++x) {
    const std::uint8_t* const group = from + x / 2 * 3;
    const auto low = static_cast<std::uint32_t>(group[2] >> 4 * (x % 2)) & 15U;
    to[x] = static_cast<std::uint16_t>(static_cast<std::uint32_t>(group[x % 2]) << 4U | low);
  }
}

/// The row next to the border stands for the one beyond it, which keeps the order of the mosaic.
std::int32_t mirrored(std::int32_t i, std::int32_t size) {
  if (i < 0) return -i;
  return i < size ? i : 2 * size - 2 - i;
}

Status check(const RawPicture& picture) {
  const auto there = static_cast<std::int64_t>(picture.bytes.size());
  if (picture.width < 2 || picture.height < 2 || picture.width > limits::max_sensor_side ||
      picture.height > limits::max_sensor_side) {
    return {StatusCode::image_too_large, picture.width, picture.height};
  }
  const std::size_t row = row_bytes(picture.format, picture.width);
  if (picture.stride < row || picture.stride > limits::max_camera_row_bytes) {
    return {StatusCode::camera_layout, static_cast<std::int64_t>(picture.stride), static_cast<std::int64_t>(row)};
  }
  const std::size_t needed = picture.stride * (static_cast<std::size_t>(picture.height) - 1) + row;
  return picture.bytes.size() < needed ? Status{StatusCode::camera_layout, there, static_cast<std::int64_t>(needed)}
                                       : Status{};
}

}  // namespace

const GreyConverter::Values& GreyConverter::values(const RawPicture& picture, std::int32_t y) {
  const auto slot = static_cast<std::size_t>(y % 3);
  Values& to = values_[slot];
  if (values_of_[slot] == y) return to;
  values_of_[slot] = y;
  const std::uint8_t* const from = picture.bytes.data() + static_cast<std::size_t>(y) * picture.stride;
  if (picture.format.packing == Packing::words) {
    unpack_words(from, picture.width, (1U << picture.format.bits) - 1U, to.data());
  } else if (picture.format.packing == Packing::mipi10) {
    unpack_mipi10(from, picture.width, to.data());
  } else if (picture.format.packing == Packing::mipi12) {
    unpack_mipi12(from, picture.width, to.data());
  } else {
    std::copy_n(from, picture.width, to.data());
  }
  return to;
}

std::span<const std::uint8_t> GreyConverter::mosaic_row(const RawPicture& picture, std::int32_t y) {
  const Values& above = values(picture, mirrored(y - 1, picture.height));
  const Values& here = values(picture, y);
  const Values& below = values(picture, mirrored(y + 1, picture.height));
  const auto width = static_cast<std::size_t>(picture.width);
  // columns_[x + 1] is the sum of column x.
  for (std::size_t x = 0; x < width; ++x) {
    columns_[x + 1] = static_cast<std::uint32_t>(above[x]) + 2U * here[x] + below[x];
  }
  columns_[0] = columns_[2];
  columns_[width + 1] = columns_[width - 1];
  const int shift = 4 + picture.format.bits - 8;
  for (std::size_t x = 0; x < width; ++x) {
    row_[x] = static_cast<std::uint8_t>((columns_[x] + 2U * columns_[x + 1] + columns_[x + 2]) >> shift);
  }
  return std::span(row_).first(width);
}

std::span<const std::uint8_t> GreyConverter::grey_row(const RawPicture& picture, std::int32_t y) {
  if (picture.format.mosaic) return mosaic_row(picture, y);
  const auto width = static_cast<std::size_t>(picture.width);
  if (picture.format.packing == Packing::bytes) {
    const auto from = picture.bytes.subspan(static_cast<std::size_t>(y) * picture.stride);
    if (picture.format.step == 1) return from.first(width);
    for (std::size_t x = 0; x < width; ++x) row_[x] = from[x * picture.format.step + picture.format.offset];
  } else {
    const Values& from = values(picture, y);
    const int shift = picture.format.bits - 8;
    for (std::size_t x = 0; x < width; ++x) row_[x] = static_cast<std::uint8_t>(from[x] >> shift);
  }
  return std::span(row_).first(width);
}

Status GreyConverter::convert(const RawPicture& picture, const Reduction& reduction, MutableGrayView image) {
  reducer_.begin(reduction, image);
  if (picture.format.packing == Packing::jpeg) {
    return decode_grey_jpeg(picture.bytes, picture.width, picture.height, row_, reducer_);
  }
  ILP_TRY(check(picture));
  values_of_.fill(-1);
  while (reducer_.next_row() < picture.height) {  // bound: one row a turn
    if (reducer_.wants_row()) {
      reducer_.add(grey_row(picture, reducer_.next_row()));
    } else {
      reducer_.add({});
    }
  }
  return {};
}

}  // namespace ilp
