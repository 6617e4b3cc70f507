// The metadata box of a product, which describes the file if everything else was lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {

/// All inputs of a product.
struct ProductSubject {
  FrameRecord frame;
  KeyframeRecord keyframe;
  PoseRecord pose;
  DepthRecord depth;
  MaskRecord mask;
  RichnessRecord richness;
  CameraModel camera;
};

/// Writes lines as in metadata.hpp. `sigma_map` and the depth's coding are for depth only. The quality of the layers is
/// written as zeros until it is known. `bytes` returns the size. `capacity_exceeded` when the lines do not fit.
Status write_product_metadata(const ProductRecord& product, const ProductSubject& subject,
                              const MissionParameters& mission, std::string_view sigma_map, std::span<std::uint8_t> out,
                              std::size_t& bytes);

/// Writes the layers' quality into the metadata of `file`, whose size stays the same. Numbers are rounded to the worse
/// side. `not_found` without the line that write_product_metadata reserves for it.
Status fill_in_layer_quality(const ProductRecord& product, std::span<std::uint8_t> file);

/// CRC-32 of all parameters' values, in the order of their table.
[[nodiscard]] std::uint32_t parameters_fingerprint(const MissionParameters& mission);

}  // namespace ilp
