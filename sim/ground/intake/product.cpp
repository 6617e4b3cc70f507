#include "sim/ground/intake/product.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "fsw/vision/codec/metadata.hpp"
#include "sim/ground/intake/ids.hpp"
#include "sim/ground/intake/record_file.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::intake {
namespace {

// The header of a hostile file must not decide how much memory is taken.
constexpr std::int64_t max_product_pixels = std::int64_t{1} << 26, max_side = 1 << 16;

}  // namespace

std::string Metadata::text(const std::string& key) const {
  std::string_view value;
  return MetadataReader(box_).text(key, value).ok() ? std::string(value) : std::string();
}

std::optional<std::int64_t> Metadata::integer(const std::string& key) const {
  std::int64_t value = 0;
  return MetadataReader(box_).integer(key, value).ok() ? std::optional(value) : std::nullopt;
}

std::optional<std::int64_t> Metadata::id(const std::string& key) const {
  const auto number = integer(key);
  return number && is_id(*number) ? number : std::nullopt;
}

std::optional<double> Metadata::number(const std::string& key) const {
  const auto one = numbers(key, 1);
  return one ? std::optional((*one)[0]) : std::nullopt;
}

std::optional<std::vector<double>> Metadata::numbers(const std::string& key, std::size_t count) const {
  std::vector<double> numbers(count);
  if (!MetadataReader(box_).reals(key, numbers).ok()) return std::nullopt;
  const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double value) { return std::isfinite(value); });
  return finite ? std::optional(numbers) : std::nullopt;
}

ProductHeader read_product_header(std::span<const std::uint8_t> file) {
  Jpeg2000Info info;
  if (const Status status = read_jpeg2000_header(file, info); !status.ok()) {
    throw BadFile("not a readable JP2 file: " + host::status_sentence(status));
  }
  if (std::int64_t{info.width} * info.height > max_product_pixels) {
    throw BadFile("an image of " + std::to_string(info.width) + " x " + std::to_string(info.height) + " pixels");
  }
  return {Metadata(info.metadata), info.layers, info.width, info.height};
}

Product decode_product(std::span<const std::uint8_t> file) {
  ProductHeader header = read_product_header(file);
  Product product{std::move(header.metadata), header.layers, host::Raster<std::int32_t>(header.width, header.height)};
  if (const Status status = decode_jpeg2000(file, false, product.samples.view()); !status.ok()) {
    throw BadFile("cannot be decoded: " + host::status_sentence(status));
  }
  return product;
}

std::optional<CameraModel> camera_of(const Metadata& metadata) {
  const auto width = metadata.integer("width"), height = metadata.integer("height");
  auto c = metadata.numbers("camera", CameraNumbers::plain);
  if (!c) c = metadata.numbers("camera", CameraNumbers::most);
  if (!width || !height || !c || *width <= 0 || *height <= 0 || *width > max_side || *height > max_side) {
    return std::nullopt;
  }
  const CameraModel camera =
      camera_of_numbers(static_cast<std::int32_t>(*width), static_cast<std::int32_t>(*height), *c);
  if (!(camera.fx > 0) || !(camera.fy > 0)) return std::nullopt;
  return camera;
}

std::optional<PoseRecord> pose_record_of(const Metadata& metadata) {
  const auto q = metadata.numbers("q_cam_from_world", 4);
  const auto centre = metadata.numbers("centre", 3), sigma = metadata.numbers("sigma", 3);
  const auto id = metadata.id("keyframe"), strip = metadata.id("strip");
  if (!q || !centre || !id || !strip) return std::nullopt;
  PoseRecord pose;
  pose.id = *id;
  pose.strip_id = *strip;
  pose.state = PoseState::final;
  for (std::size_t i = 0; i < 4; ++i) pose.q_cam_from_world[i] = (*q)[i];
  for (std::size_t i = 0; i < 3; ++i) {
    pose.centre[i] = (*centre)[i];
    pose.sigma[i] = sigma ? (*sigma)[i] : unknown;
  }
  return pose;
}

}  // namespace ilp::intake
