#include "fsw/products/product_metadata.hpp"

#include <array>
#include <bit>
#include <cmath>

#include "cfg/version.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "fsw/vision/codec/metadata.hpp"

namespace ilp {
namespace {

constexpr std::string_view quality_key = "layer_quality";
// Four digits, a point, four digits.
constexpr std::size_t number_width = 9;
constexpr double largest_number = 9999.9999;
using QualityText = std::array<char, limits::max_quality_layers*(number_width + 1)>;

/// Numbers of fixed width with a blank between them.
std::string_view quality_text(std::span<const float> quality, ProductKind kind, QualityText& text) {
  std::size_t size = 0;
  for (const float value : quality) {
    if (size > 0) text[size++] = ' ';
    const double bounded = value < 0 ? 0 : value < largest_number ? static_cast<double>(value) : largest_number;
    const double scaled = kind == ProductKind::depth ? std::ceil(bounded * 1e4) : std::floor(bounded * 1e4);
    auto digits = static_cast<std::uint64_t>(scaled);
    for (std::size_t i = number_width; i-- > 0;) {
      if (i == 4) {
        text[size + i] = '.';
        continue;
      }
      text[size + i] = static_cast<char>('0' + digits % 10);
      digits /= 10;
    }
    size += number_width;
  }
  return {text.data(), size};
}

const char* scheme_name(ProductScheme scheme) {
  switch (scheme) {
    case ProductScheme::lossless_region:
      return "lossless_region";
    case ProductScheme::thumbnail:
      return "thumbnail";
    default:
      return "lossy_region";
  }
}

void write_origin(MetadataWriter& writer, const ProductRecord& product, const ProductSubject& subject) {
  writer.integer("product", product.id);
  writer.integer("keyframe", product.keyframe_id);
  writer.integer("strip", product.strip_id);
  writer.text("kind", name_of(product.kind));
  writer.text("frame_name", subject.frame.name);
  writer.integer("time_ns", subject.frame.time_ns);
  writer.integer("width", subject.frame.width);
  writer.integer("height", subject.frame.height);
  if (subject.keyframe.degraded != 0) writer.integer("degraded", subject.keyframe.degraded);
}

/// Rounds to two hexadecimal digits, which take few characters.
double eight_bits(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(std::floor(mantissa * 256 + 0.5) / 256, exponent);
}

/// Writes the covariance of attitude and centre as sigmas and correlations in percent. The record has all digits.
void write_covariance(MetadataWriter& writer, const PoseRecord& pose) {
  constexpr std::size_t size = 6;
  double sigma[size] = {};
  for (std::size_t i = 0, k = 0; i < size; k += ++i + 1)
    sigma[i] = std::sqrt(pose.covariance[k] > 0 ? pose.covariance[k] : 0);
  double correlation[size * (size - 1) / 2] = {};
  for (std::size_t i = 1, k = 0; i < size; ++i) {
    for (std::size_t j = 0; j < i; ++j, ++k) {
      const double product = sigma[i] * sigma[j];
      if (product > 0) correlation[k] = std::floor(100 * pose.covariance[i * (i + 1) / 2 + j] / product + 0.5);
    }
  }
  for (double& s : sigma) s = eight_bits(s);
  writer.reals("sigma_attitude_rad", std::span(sigma).first(3));
  writer.reals("pose_correlation_percent", correlation);
}

void write_camera_and_pose(MetadataWriter& writer, const ProductSubject& subject) {
  const PoseRecord& pose = subject.pose;
  // It follows the pose, not the present camera, whose state depends on timing.
  writer.reals("camera", camera_numbers(subject.camera).span());
  if (pose.state != PoseState::final) return;
  writer.reals("q_cam_from_world", pose.q_cam_from_world);
  writer.reals("centre", pose.centre);
  writer.reals("sigma", pose.sigma);
  write_covariance(writer, pose);
  writer.integer("scale_source", static_cast<std::int64_t>(pose.scale_source));
}

void write_index(MetadataWriter& writer, const RichnessRecord& r) {
  const double cues[] = {r.gradient_fine,    r.gradient_coarse, r.entropy,      r.contrast,
                         r.relief,           r.slope_steep,     r.slope_excess, r.roughness_fine,
                         r.roughness_coarse, r.curvature,       r.novelty,      r.mask_fraction};
  std::array<double, std::size(cues)> rounded{};
  // The record has all digits; here a thousandth is enough.
  for (std::size_t i = 0; i < rounded.size(); ++i) rounded[i] = std::floor(cues[i] * 1000 + 0.5) / 1000;
  writer.real("richness", r.richness);
  writer.reals("richness_terms", rounded);
}

}  // namespace

Status write_product_metadata(const ProductRecord& product, const ProductSubject& subject,
                              const MissionParameters& mission, std::string_view sigma_map, std::span<std::uint8_t> out,
                              std::size_t& bytes) {
  MetadataWriter writer(out);
  writer.text("software", software_version);
  writer.integer("parameters", parameters_fingerprint(mission));
  write_origin(writer, product, subject);
  write_camera_and_pose(writer, subject);
  write_index(writer, subject.richness);
  writer.text("scheme", scheme_name(product.scheme));
  writer.integer("grant_bytes", product.grant_bytes);
  writer.integer("mask_pixels", subject.mask.newly_seen);
  QualityText text{};
  const std::array<float, limits::max_quality_layers> unknown_yet{};
  const std::size_t layers = mission.quality_layers;
  writer.text(quality_key, quality_text(std::span(unknown_yet).first(layers), product.kind, text));
  if (product.kind == ProductKind::depth) {
    writer.real("depth_offset", subject.depth.offset);
    writer.real("depth_step", subject.depth.step);
    writer.real("disparity_per_inverse_depth_px", subject.depth.disparity_per_inverse_depth_px);
    writer.integer("partner", subject.depth.partner_id);
    if (subject.depth.blind_radius_px > 0) {
      const double disc[] = {subject.depth.epipole_x, subject.depth.epipole_y, subject.depth.blind_radius_px};
      writer.reals("blind_disc_px", disc);
    }
    if (subject.depth.pose_sigma > 0) writer.real("pose_sigma", subject.depth.pose_sigma);
    writer.text("sigma_map", sigma_map);
  }
  bytes = writer.bytes().size();
  return writer.status();
}

Status fill_in_layer_quality(const ProductRecord& product, std::span<std::uint8_t> file) {
  Jpeg2000Info info;
  ILP_TRY(read_jpeg2000_header(file, info));
  std::string_view zeros;
  ILP_TRY(MetadataReader(info.metadata).text(quality_key, zeros));
  QualityText text{};
  const std::size_t layers = (zeros.size() + 1) / (number_width + 1);
  if (layers < 1 || layers > limits::max_quality_layers) return StatusCode::not_found;
  const std::string_view numbers = quality_text(std::span(product.layer_quality).first(layers), product.kind, text);
  if (numbers.size() != zeros.size()) return StatusCode::not_found;
  const auto at = static_cast<std::size_t>(reinterpret_cast<const std::uint8_t*>(zeros.data()) - file.data());
  for (std::size_t i = 0; i < numbers.size(); ++i) file[at + i] = static_cast<std::uint8_t>(numbers[i]);
  return {};
}

std::uint32_t parameters_fingerprint(const MissionParameters& mission) {
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const auto bits = std::bit_cast<std::uint64_t>(parameter_value(mission, i));
    std::array<std::uint8_t, 8> bytes{};
    store_little_endian(bits, bytes.data());
    crc = crc32(bytes, crc);
  }
  return crc;
}

}  // namespace ilp
