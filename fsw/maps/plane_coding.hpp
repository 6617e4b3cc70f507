// Compression of one plane of whole numbers, such as a tile's image or its heights: the reversible 5/3 wavelet
// transform, coefficients in equal steps of what an error of them does to the plane, and adaptive arithmetic coding in
// contexts of their neighbours. It serves where OpenJPEG does not: one thread at a time may use OpenJPEG's memory, and
// the worker does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr std::int32_t lossless_step = 0;
inline constexpr std::int32_t finest_plane_step = 64;  ///< 1/64 of the plane's unit
inline constexpr std::int32_t coarsest_plane_step = 1 << 15;
inline constexpr std::int32_t largest_plane_sample = 1 << 16;  ///< magnitude

[[nodiscard]] constexpr bool is_plane_step(std::int32_t step) {
  return step == lossless_step || (step >= finest_plane_step && step <= coarsest_plane_step);
}

/// Codes the plane, which is void afterwards, with a step in 1/64 of its unit, or without loss. |sample| at most
/// largest_plane_sample; no side above 1024; `scratch` holds as many samples as the plane. Bytes that do not fit are
/// only counted: the result is the size.
[[nodiscard]] std::size_t encode_plane(ImageView<std::int32_t> plane, std::int32_t step, std::int32_t* scratch,
                                       std::span<std::uint8_t> bytes);

/// Decodes a plane whose size and step the caller knows. Any bytes are safe: `truncated`, `parse_error` (a = offset)
/// for what encode_plane has not written, as far as it shows; `invalid_argument` for the step.
Status decode_plane(std::span<const std::uint8_t> bytes, std::int32_t step, std::int32_t* scratch,
                    ImageView<std::int32_t> plane);

}  // namespace ilp
