#include "fsw/products/depth_access.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/crc.hpp"

namespace ilp {

std::uint32_t checksum_of_mask(const MaskRecord& mask, const MapBuffers& maps) {
  if (mask.code.bytes > maps.bytes.size()) return 0;
  return crc32c(std::span(maps.bytes).first(mask.code.bytes));
}

Status load_mask(Reader<MaskRecord> store, const MaskRecord& mask, MapBuffers& maps, const DecodedMask& earlier) {
  ILP_TRY(maps.mask.resize(mask.width, mask.height));
  if (mask.code.bytes == 0 || mask.code.bytes > maps.bytes.size()) return {StatusCode::not_found, mask.id};
  ILP_TRY(read_blob<MaskRecord>(store, "code", mask.id, 0, {maps.bytes.data(), mask.code.bytes}));
  const ImageView<std::uint8_t> pixels = maps.mask.view();
  const bool same_size = earlier.mask.width == pixels.width && earlier.mask.height == pixels.height;
  if (same_size && earlier.checksum != 0 && earlier.checksum == checksum_of_mask(mask, maps)) {
    std::copy_n(earlier.mask.data, pixels.area(), pixels.data);
    return {};
  }
  return decode_mask(maps.bytes.data(), mask.code.bytes, pixels);
}

Status load_maps(Reader<DepthRecord, MaskRecord> store, const DepthRecord& depth, const MaskRecord& mask,
                 MapBuffers& maps, const DecodedMask& earlier) {
  ILP_TRY(load_mask(store, mask, maps, earlier));
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
