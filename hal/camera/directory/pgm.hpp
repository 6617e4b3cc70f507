// Reads binary PGM images (netpbm P5) with 8 bits per pixel.
#pragma once

#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"

namespace ilp {

/// Reads an image of at most the size of the flight's images. Returns `not_found` or `io_error` (first value: errno) if
/// the file cannot be opened, `unsupported_format` if it is no PGM file of 8 bits, `parse_error` if its header is
/// malformed, `image_too_large` if the image does not fit, `truncated` if the file ends too early.
Status read_pgm(const char* path, FrameImage& image);
/// Reads a picture of `width` x `height`, or of any size if they are 0, and reduces it if it is larger than the
/// flight's images (find_reduction). Returns the statuses of read_pgm(), and `image_size_changed` (first value: width,
/// second: height) if the picture has another size. `rows` is scratch.
Status read_large_pgm(const char* path, std::int32_t width, std::int32_t height, RowReducer& rows, FrameImage& image);
/// Reads only the image's size. Returns the statuses of read_pgm().
Status read_pgm_size(const char* path, std::int32_t& width, std::int32_t& height);

}  // namespace ilp
