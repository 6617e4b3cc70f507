#include "fsw/products/product_coding.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/products/product_metadata.hpp"
#include "fsw/shared/product_layers.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"

namespace ilp {
namespace {

// In steps of the codes: half a step for rounding, the rest for the ground's single precision.
constexpr double rounding_steps = 0.51;

Status encode(ProductCoding& job, Jpeg2000Product& coded) {
  const MaskView mask = job.region ? MaskView(job.newly_seen()) : MaskView{};
  if (job.product.kind == ProductKind::depth) {
    return encode_jpeg2000(job.codes(), depth_code_bits, mask, job.params, job.box.view(), job.jpeg2000, job.file(),
                           coded);
  }
  const Status status = encode_jpeg2000(job.image(), mask, job.params, job.box.view(), job.jpeg2000, job.file(), coded);
  if (!job.params.lossless || !status.is(StatusCode::grant_too_small)) return status;
  job.product.scheme = ProductScheme::lossy_region;
  job.params.lossless = false;
  return encode_jpeg2000(job.image(), mask, job.params, job.box_if_lossy.view(), job.jpeg2000, job.file(), coded);
}

float estimated_error_px(const ProductCoding& job, std::int32_t codes) {
  return static_cast<float>((codes + rounding_steps) * job.px_per_code);
}

bool keeps_required_error(const ProductCoding& job, float error_px) {
  return static_cast<double>(error_px) <= job.depth_error_px;
}

/// The largest error in codes that keeps the required one; -1: none does, or none is required.
std::int32_t enough_codes(const ProductCoding& job) {
  if (!(job.depth_error_px > 0)) return -1;
  constexpr std::int32_t codes = std::int32_t{1} << depth_code_bits;
  const double most = job.depth_error_px / job.px_per_code;
  auto enough = most < codes ? static_cast<std::int32_t>(most) : codes;
  while (enough >= 0 && !keeps_required_error(job, estimated_error_px(job, enough))) --enough;
  return enough;
}

Status measure_layers(ProductCoding& job, const Jpeg2000Product& coded) {
  ProductRecord& product = job.product;
  product.bytes = static_cast<std::uint32_t>(coded.bytes);
  product.layers = static_cast<std::uint8_t>(coded.layers);
  const std::span<const std::uint8_t> file = job.file().first(coded.bytes);
  const bool depth = product.kind == ProductKind::depth;
  LayerErrors errors;
  if (depth) {
    ILP_TRY(measure_layer_errors(file, job.codes(), job.newly_seen(), errors, enough_codes(job)));
  } else {
    const MaskView mask = product.scheme == ProductScheme::thumbnail ? MaskView{} : MaskView(job.newly_seen());
    ILP_TRY(measure_layer_errors(file, job.image(), mask, errors));
  }
  for (std::size_t i = 0; i < product.layers; ++i) {
    product.layer_bytes[i] = static_cast<std::uint32_t>(coded.layer_bytes[i]);
    product.layer_quality[i] =
        depth ? estimated_error_px(job, errors.largest[i]) : static_cast<float>(psnr_of(errors.mean_square[i]));
  }
  return {};
}

/// Layers with digits below the requested error are not worth their bytes.
Status truncate_layers(ProductCoding& job) {
  ProductRecord& product = job.product;
  if (product.kind != ProductKind::depth || !(job.depth_error_px > 0)) return {};
  std::uint8_t needed = 0;
  bool kept = false;
  while (!kept && needed < product.layers) {
    kept = keeps_required_error(job, product.layer_quality[needed]);
    ++needed;
  }
  if (needed == product.layers) return {};
  std::size_t bytes = 0;
  ILP_TRY(truncate_to_layers(job.file().first(product.bytes), needed, bytes));
  keep_layers(needed, bytes, product);
  return {};
}

void know_library(ProductCoding& job) {
  if (job.library == CodecLibrary::untried) {
    job.library = openjpeg_digest() == tested_openjpeg_digest ? CodecLibrary::as_tested : CodecLibrary::other;
  }
  job.params.library_transform = job.library == CodecLibrary::other;
}

Status code(ProductCoding& job) {
  Jpeg2000Product coded;
  know_library(job);
  ILP_TRY(encode(job, coded));
  if (coded.bytes > job.product.grant_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(coded.bytes), job.product.grant_bytes};
  }
  ILP_TRY(measure_layers(job, coded));
  ILP_TRY(truncate_layers(job));
  const std::span<std::uint8_t> file = job.file().first(job.product.bytes);
  ILP_TRY(fill_in_layer_quality(job.product, file));
  job.product.crc32 = crc32(file);
  job.product.data.bytes = job.product.bytes;
  return {};
}

}  // namespace

void code_product(void* coding) {
  auto& job = *static_cast<ProductCoding*>(coding);
  job.status = code(job);
}

}  // namespace ilp
