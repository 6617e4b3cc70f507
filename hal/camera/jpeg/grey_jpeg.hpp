// Luma of a JPEG picture, without a heap and without trust in its bytes.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "hal/camera/picture/reduction.hpp"

namespace ilp {

/// Decodes a JPEG file of 8 bits with Huffman codes in one scan, as cameras send it (baseline and extended sequential),
/// in grey or colour, and gives its luma to `rows`. `row` is scratch of at least `width` bytes. Tables that the file
/// leaves out are those of the standard's annex K.
///
/// Nothing is guessed: a file in which the decoder finds anything wrong before the last row is refused, and `rows` then
/// hold a part of a picture. `image_size_changed` (the file's sides) for another size than `width` x `height`,
/// `truncated`, `unsupported_format` for progressive files, files in several scans and arithmetic codes,
/// `parse_error` (a = libjpeg's number of the message), `arena_exhausted` (limits::jpeg_arena_bytes).
///
/// The time is bounded by the bytes of the file and the pixels of the picture, and the memory by `width`: a whole
/// picture of coefficients, as progressive files need it, is never in memory.
Status decode_grey_jpeg(std::span<const std::uint8_t> file, std::int32_t width, std::int32_t height,
                        std::span<std::uint8_t> row, RowReducer& rows);

}  // namespace ilp
