// A small product with real quality layers.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "fsw/base/crc.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp::test {

/// The file of a textured image of 64 x 64 pixels in four layers, about 4 kB; `file` is cut to its size.
inline ProductRecord coded_product(std::int64_t keyframe_id, ProductKind kind, int seed,
                                   std::vector<std::uint8_t>& file) {
  constexpr std::int32_t side = 64;
  Rng random(static_cast<std::uint64_t>(seed) + 1, 7);
  std::vector<std::uint8_t> pixels(side * side);
  for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(64 + random.below(128));
  Jpeg2000Params params{.max_bytes = 4000, .region = RegionCoding::none, .layers = 4};
  static const auto workspace = std::make_unique<Jpeg2000Workspace>();
  file.resize(20'000);
  Jpeg2000Product coded;
  const GrayView view{pixels.data(), side, side, side};
  EXPECT_TRUE(encode_jpeg2000(view, MaskView{}, params, {}, *workspace, file, coded).ok());
  file.resize(coded.bytes);
  ProductRecord product;
  product.id = product_id(keyframe_id, kind);
  product.keyframe_id = keyframe_id;
  product.kind = kind;
  product.grant_bytes = 4000;
  product.bytes = static_cast<std::uint32_t>(coded.bytes);
  product.data.bytes = product.bytes;
  product.crc32 = crc32(file);
  product.layers = static_cast<std::uint8_t>(coded.layers);
  for (std::size_t i = 0; i < product.layers; ++i) {
    product.layer_bytes[i] = static_cast<std::uint32_t>(coded.layer_bytes[i]);
    product.layer_quality[i] = 20.0F + 4.0F * static_cast<float>(i);
  }
  return product;
}

}  // namespace ilp::test
