// Loads a keyframe's depth and mask from the store into a component's own buffers.
#pragma once

#include <array>

#include "fsw/vision/terrain/mask_coding.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

struct MapBuffers {
  FixedImage<std::uint16_t, limits::max_image_pixels> codes;  ///< inverse depth = offset + step * code, 0 invalid
  FixedImage<std::uint8_t, limits::max_image_pixels> sigma;   ///< codes of sigma_map.hpp
  FixedImage<std::uint8_t, limits::max_image_pixels> mask;    ///< newly seen
  std::array<std::uint8_t, max_mask_bytes(limits::max_image_pixels)> bytes{};
};

/// A mask that was decoded earlier, and what checksum_of_mask() gave for its code.
struct DecodedMask {
  MaskView mask;
  std::uint32_t checksum = 0;  ///< 0: there is none
};

/// Of the code of the mask that was loaded last.
[[nodiscard]] std::uint32_t checksum_of_mask(const MaskRecord& mask, const MapBuffers& maps);

/// The mask alone; the other maps stay as they are. A mask with the code of `earlier` is copied instead of decoded.
/// `not_found` when it has been released.
Status load_mask(Reader<MaskRecord> store, const MaskRecord& mask, MapBuffers& maps, const DecodedMask& earlier = {});
/// Depth and mask. Without depth, codes and sigma are all zero. `not_found` when the mask has been released.
Status load_maps(Reader<DepthRecord, MaskRecord> store, const DepthRecord& depth, const MaskRecord& mask,
                 MapBuffers& maps, const DecodedMask& earlier = {});

}  // namespace ilp
