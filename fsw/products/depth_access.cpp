#include "fsw/products/depth_access.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/crc.hpp"

namespace ilp {

std::uint32_t checksum_of_mask(const DepthRecord& depth, const MapBuffers& maps) {
  if (depth.mask.bytes > maps.bytes.size()) return 0;
  return crc32c(std::span(maps.bytes).first(depth.mask.bytes));
}

Status load_mask(Reader<DepthRecord> store, const DepthRecord& depth, MapBuffers& maps, const DecodedMask& earlier) {
  ILP_TRY(maps.mask.resize(depth.width, depth.height));
  if (depth.mask.bytes == 0 || depth.mask.bytes > maps.bytes.size()) return {StatusCode::not_found, depth.id};
  ILP_TRY(read_blob<DepthRecord>(store, "mask", depth.id, 0, {maps.bytes.data(), depth.mask.bytes}));
  const ImageView<std::uint8_t> mask = maps.mask.view();
  const bool same_size = earlier.mask.width == mask.width && earlier.mask.height == mask.height;
  if (same_size && earlier.checksum != 0 && earlier.checksum == checksum_of_mask(depth, maps)) {
    std::copy_n(earlier.mask.data, mask.area(), mask.data);
    return {};
  }
  return decode_mask(maps.bytes.data(), depth.mask.bytes, mask);
}

Status load_maps(Reader<DepthRecord> store, const DepthRecord& depth, MapBuffers& maps, const DecodedMask& earlier) {
  ILP_TRY(load_mask(store, depth, maps, earlier));
  ILP_TRY(maps.codes.resize(depth.width, depth.height));
  ILP_TRY(maps.sigma.resize(depth.width, depth.height));
  const std::size_t area = maps.mask.view().area();
  auto* codes = reinterpret_cast<std::uint8_t*>(maps.codes.view().data);
  std::uint8_t* sigma = maps.sigma.view().data;
  if (depth.values.bytes != 2 * area || depth.sigma.bytes != area) {
    std::memset(codes, 0, 2 * area);
    std::memset(sigma, 0, area);
    return {};
  }
  ILP_TRY(read_blob<DepthRecord>(store, "values", depth.id, 0, {codes, 2 * area}));
  return read_blob<DepthRecord>(store, "sigma", depth.id, 0, {sigma, area});
}

}  // namespace ilp
