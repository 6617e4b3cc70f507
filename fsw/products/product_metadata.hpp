// Writes the metadata box of a product, which describes the file even if everything else is lost.
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

/// Writes the metadata as lines (metadata.hpp); `bytes` gets their size. `sigma_map` and the coding of depth are
/// written for depth only. The quality of the layers is written as zeros, because it is not known yet. Returns
/// `capacity_exceeded` if the lines do not fit.
Status write_product_metadata(const ProductRecord& product, const ProductSubject& subject,
                              const MissionParameters& mission, std::string_view sigma_map, std::span<std::uint8_t> out,
                              std::size_t& bytes);

/// Writes the quality of the layers into the metadata of `file`, whose size does not change. Numbers are rounded
/// towards lower quality. Returns `not_found` if the line that write_product_metadata reserves is missing.
Status fill_in_layer_quality(const ProductRecord& product, std::span<std::uint8_t> file);

/// CRC-32 of the values of all parameters, in the order of their table.
[[nodiscard]] std::uint32_t parameters_fingerprint(const MissionParameters& mission);

}  // namespace ilp
