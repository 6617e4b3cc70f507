#include "fsw/products/depth_access.hpp"

#include <cstring>

namespace ilp {

Status load_mask(Reader<DepthRecord> store, const DepthRecord& depth, MapBuffers& maps) {
  ILP_TRY(maps.mask.resize(depth.width, depth.height));
  if (depth.mask.bytes == 0 || depth.mask.bytes > maps.bytes.size()) return {StatusCode::not_found, depth.id};
  ILP_TRY(read_blob<DepthRecord>(store, "mask", depth.id, 0, {maps.bytes.data(), depth.mask.bytes}));
  return decode_mask(maps.bytes.data(), depth.mask.bytes, maps.mask.view());
}

Status load_maps(Reader<DepthRecord> store, const DepthRecord& depth, MapBuffers& maps) {
  ILP_TRY(load_mask(store, depth, maps));
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
