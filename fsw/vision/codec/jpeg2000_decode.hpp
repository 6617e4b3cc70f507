// Decodes files of encode_jpeg2000, and any JP2 file or bare codestream of one component. For the ground and the lab.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

struct Jpeg2000Info {
  std::int32_t width = 0;
  std::int32_t height = 0;
  int bits = 0;
  bool is_signed = false;
  int layers = 0;
  int wavelet_levels = 0;
  std::span<const std::uint8_t> metadata;    ///< content of our metadata box, inside the input; empty without one
  std::span<const std::uint8_t> codestream;  ///< inside the input
};

/// The input may be hostile: `parse_error`, `truncated`, `unsupported_format` (more than one component, more than 25
/// bits, an image above 2^28 pixels, more than 1024 tiles).
Status read_jpeg2000_header(std::span<const std::uint8_t> file, Jpeg2000Info& info);

/// `samples` has the width and height of the header. With `allow_truncated`, a codestream that ends early is decoded as
/// far as it goes (a file received in part); without it, that is an error. Nothing is printed. `codec_failed` when the
/// codestream is damaged, `arena_exhausted` where memory is fixed.
Status decode_jpeg2000(std::span<const std::uint8_t> file, bool allow_truncated, ImageView<std::int32_t> samples);

}  // namespace ilp
