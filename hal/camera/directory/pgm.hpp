// Binary PGM images (netpbm P5), 8 bit.
#pragma once

#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"

namespace ilp {

/// `not_found`, `unsupported_format`, `parse_error`, `image_too_large`, `truncated`.
Status read_pgm(const char* path, FrameImage& image);
/// Reads a picture of `width` x `height`, or of any size if they are 0, and reduces it if it is larger than the
/// flight's images (find_reduction). Statuses as above, and `image_size_changed` (the picture's sides).
Status read_large_pgm(const char* path, std::int32_t width, std::int32_t height, RowReducer& rows, FrameImage& image);
/// Reads the image's size only. Statuses as above.
Status read_pgm_size(const char* path, std::int32_t& width, std::int32_t& height);

}  // namespace ilp
