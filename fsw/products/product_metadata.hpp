// The metadata box of a product: what a file says of itself when everything else was lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {

/// Everything that a product is made of.
struct ProductSubject {
  FrameRecord frame;
  KeyframeRecord keyframe;
  PoseRecord pose;
  DepthRecord depth;
  RichnessRecord richness;
  CameraModel camera;
};

/// Lines of metadata.hpp. `sigma_map` and the depth's coding only for depth. The quality of the layers stands as zeros
/// until it is known. `bytes` were written. capacity_exceeded when they do not fit.
Status write_product_metadata(const ProductRecord& product, const ProductSubject& subject,
                              const MissionParameters& mission, std::string_view sigma_map, std::span<std::uint8_t> out,
                              std::size_t& bytes);

/// Puts the layers' quality into the metadata of `file`, which has exactly as many bytes before as after. Numbers are
/// rounded to the worse side. not_found without the line that write_product_metadata leaves for it.
Status fill_in_layer_quality(const ProductRecord& product, std::span<std::uint8_t> file);

/// CRC-32 of all parameters' values, in the order of their table.
[[nodiscard]] std::uint32_t parameters_fingerprint(const MissionParameters& mission);

}  // namespace ilp
