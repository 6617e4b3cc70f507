#include "sim/ground/intake/keyframe_rasters.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/terrain/mask_coding.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"

namespace ilp::intake {
namespace {

host::Raster<std::uint8_t> image_of(const Product& product) {
  host::Raster<std::uint8_t> image(product.samples.width, product.samples.height);
  for (std::size_t i = 0; i < image.samples.size(); ++i) {
    image.samples[i] = static_cast<std::uint8_t>(std::clamp(product.samples.samples[i], 0, 255));
  }
  return image;
}

/// Empty where the product has none, or one of another size.
host::Raster<float> sigma_blocks_of(const Product& product) {
  const std::string text = product.metadata.text("sigma_map");
  const auto scale = product.metadata.number("disparity_per_inverse_depth_px");
  const std::int32_t columns = sigma_map_side(product.samples.width), rows = sigma_map_side(product.samples.height);
  const bool fits = text.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (!fits || !scale || !(*scale > 0)) return {};
  host::Raster<float> blocks(columns, rows);
  for (std::size_t i = 0; i < text.size(); ++i) {
    blocks.samples[i] = static_cast<float>(sigma_of_character(text[i]) / (sigma_codes_per_px * *scale));
  }
  return blocks;
}

void take_mask(const Keyframe& keyframe, host::Raster<std::uint8_t>& mask) {
  mask = host::Raster<std::uint8_t>(keyframe.mask_width, keyframe.mask_height);
  const std::vector<std::uint8_t> coded = keyframe.coded_mask.bytes();
  if (!decode_mask(coded.data(), coded.size(), mask.view()).ok()) mask = {};
}

void take_depth(const Product& product, double depth_scale, KeyframeRasters& rasters) {
  auto scale = depth_scale_of(product.metadata);
  if (!scale) throw BadFile("does not state its scale");
  scale->offset /= depth_scale;
  scale->step /= depth_scale;
  const host::Raster<std::int32_t>& samples = product.samples;
  if (!rasters.mask.same_size(samples.width, samples.height)) {
    rasters.mask = host::Raster<std::uint8_t>(samples.width, samples.height, 0);
  }
  rasters.sigma_blocks = sigma_blocks_of(product);
  for (float& sigma : rasters.sigma_blocks.samples) sigma = static_cast<float>(sigma / depth_scale);
  rasters.depth_step = scale->step;
  rasters.inverse_depth = host::Raster<float>(samples.width, samples.height);
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    const double inverse = scale->offset + scale->step * samples.samples[i];
    const bool valid = rasters.mask.samples[i] != 0 && samples.samples[i] >= 1 && inverse > 1 / largest_coordinate &&
                       inverse < largest_coordinate;
    rasters.inverse_depth.samples[i] = valid ? static_cast<float>(inverse) : 0.0F;
  }
}

}  // namespace

std::optional<DepthScale> depth_scale_of(const Metadata& metadata) {
  const auto offset = metadata.number("depth_offset"), step = metadata.number("depth_step");
  if (!offset || !step || !(*step > 0)) return std::nullopt;
  return DepthScale{*offset, *step};
}

DecodedProducts decode_products(const Keyframe& keyframe) {
  DecodedProducts decoded{keyframe, {}};
  KeyframeRasters& rasters = decoded.rasters;
  if (rasters.mask.empty() && !keyframe.coded_mask.empty()) take_mask(keyframe, rasters.mask);
  for (const ProductKind kind : {ProductKind::depth, ProductKind::image}) {
    const auto& file = keyframe.product_files[static_cast<std::size_t>(kind)];
    const bool is_image = kind == ProductKind::image;
    const bool decoded_already = is_image ? !rasters.image.empty() : !rasters.inverse_depth.empty();
    if (file.empty() || decoded_already) continue;
    try {
      const Product product = decode_product(file.bytes());
      if (is_image) {
        rasters.image = image_of(product);
      } else {
        take_depth(product, keyframe.depth_scale, rasters);
      }
    } catch (const BadFile& fault) {
      decoded.faults[static_cast<std::size_t>(kind)] = fault.what();
    }
  }
  return decoded;
}

double inverse_depth_sigma(const KeyframeRasters& keyframe, std::int32_t x, std::int32_t y) {
  const std::int32_t column = x / sigma_block_px, row = y / sigma_block_px;
  const host::Raster<float>& blocks = keyframe.sigma_blocks;
  if (x < 0 || y < 0 || column >= blocks.width || row >= blocks.height) return 0;
  const double matching = blocks.at(column, row);
  if (!(matching > 0)) return 0;
  return std::sqrt(matching * matching + keyframe.depth_step * keyframe.depth_step / 12);
}

void drop_faulty(Keyframe& keyframe, const std::array<std::string, 2>& faults, Outbox& outbox) {
  for (std::size_t kind = 0; kind < faults.size(); ++kind) {
    if (faults[kind].empty() || !keyframe.products[kind]) continue;
    for (ReceivedFile& file : outbox.files) {
      if (file.name == keyframe.products[kind]->file) file.fault = faults[kind];
    }
    keyframe.products[kind].reset();
    keyframe.product_files[kind].clear();
  }
}

}  // namespace ilp::intake
