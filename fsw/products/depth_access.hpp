// Loads a keyframe's depth and mask from the store into a component's own buffers.
#pragma once

#include <array>

#include "fsw/vision/terrain/mask_coding.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

struct MapBuffers {
  FixedImage<std::uint16_t, limits::max_image_pixels> codes;  ///< inverse depth = offset + step * code; 0: no depth
  FixedImage<std::uint8_t, limits::max_image_pixels> sigma;   ///< codes of sigma_map.hpp
  FixedImage<std::uint8_t, limits::max_image_pixels> mask;    ///< newly seen pixels
  std::array<std::uint8_t, max_mask_bytes(limits::max_image_pixels)> bytes{};
};

/// A mask that was decoded earlier, with the checksum of its code.
struct DecodedMask {
  MaskView mask;
  std::uint32_t checksum = 0;  ///< from checksum_of_mask(); 0: there is no mask
};

/// Checksum of the code of the mask that was loaded last into `maps`.
[[nodiscard]] std::uint32_t checksum_of_mask(const MaskRecord& mask, const MapBuffers& maps);

/// Loads only the mask; the other maps stay unchanged. A mask with the same code as `earlier` is copied instead of
/// decoded. Returns `not_found` if the mask has been released.
Status load_mask(Reader<MaskRecord> store, const MaskRecord& mask, MapBuffers& maps, const DecodedMask& earlier = {});
/// Loads depth and mask. Without depth, codes and sigma are zero. Returns `not_found` if the mask has been released.
Status load_maps(Reader<DepthRecord, MaskRecord> store, const DepthRecord& depth, const MaskRecord& mask,
                 MapBuffers& maps, const DecodedMask& earlier = {});

}  // namespace ilp
