// Compression of one plane of integers, such as a tile's image or its heights: the reversible 5/3 wavelet transform,
// quantisation with a step that has the same effect on the plane for all coefficients, and adaptive arithmetic coding
// with contexts from neighbouring coefficients. OpenJPEG is not used here, because only one thread may use its memory,
// and that is the worker.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr std::int32_t lossless_step = 0;
inline constexpr std::int32_t finest_plane_step = 64;          ///< in 1/64 of the plane's unit
inline constexpr std::int32_t coarsest_plane_step = 1 << 15;   ///< in 1/64 of the plane's unit
inline constexpr std::int32_t largest_plane_sample = 1 << 16;  ///< largest |sample|

[[nodiscard]] constexpr bool is_plane_step(std::int32_t step) {
  return step == lossless_step || (step >= finest_plane_step && step <= coarsest_plane_step);
}

/// Codes the plane with a quantisation step in 1/64 of its unit, or without loss (lossless_step), and returns the size
/// in bytes. Bytes that do not fit into `bytes` are only counted. The plane is undefined afterwards. |sample| is at
/// most largest_plane_sample, sides are at most 1024, and `scratch` has as many samples as the plane.
[[nodiscard]] std::size_t encode_plane(ImageView<std::int32_t> plane, std::int32_t step, std::int32_t* scratch,
                                       std::span<std::uint8_t> bytes);

/// Decodes a plane whose size and step the caller knows. Any bytes are safe. Returns `truncated` or `parse_error`
/// (first value: offset) if the bytes are recognised as not written by encode_plane, and `invalid_argument` for a wrong
/// step.
Status decode_plane(std::span<const std::uint8_t> bytes, std::int32_t step, std::int32_t* scratch,
                    ImageView<std::int32_t> plane);

}  // namespace ilp
