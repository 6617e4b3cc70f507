// Decodes the luma of an untrusted JPEG file in an arena of fixed size.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "hal/camera/picture/reduction.hpp"

namespace ilp {

/// Decodes a JPEG file of `width` x `height` pixels and adds its luma to `rows`, row by row. Accepts what cameras send:
/// 8 bits, grey or colour, one scan with Huffman codes (baseline or extended sequential). `row` is scratch of at least
/// `width` bytes. If the file has no Huffman tables, those of the standard's annex K are used.
///
/// A file with any error before the last row is refused; `rows` then holds a part of a picture. Returns
/// `image_size_changed` (first value: width, second: height) if the file has another size, `truncated` if it ends too
/// early, `unsupported_format` for progressive files, several scans or arithmetic codes, `parse_error` (first value:
/// libjpeg's message number) for other errors, and `arena_exhausted` if limits::jpeg_arena_bytes do not suffice.
///
/// The time is bounded by the size of the file and the number of pixels. The memory is bounded by `width`, because the
/// coefficients of a complete picture are never in memory.
Status decode_grey_jpeg(std::span<const std::uint8_t> file, std::int32_t width, std::int32_t height,
                        std::span<std::uint8_t> row, RowReducer& rows);

}  // namespace ilp
