// Decodes files of encode_jpeg2000, and any JP2 file or bare codestream with one component. For use on the ground and
// in tests.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

struct Jpeg2000Info {
  std::int32_t width = 0;
  std::int32_t height = 0;
  int bits = 0;  ///< bits per sample
  bool is_signed = false;
  int layers = 0;
  int wavelet_levels = 0;
  std::span<const std::uint8_t> metadata;    ///< content of the metadata box, inside the input; empty if there is none
  std::span<const std::uint8_t> codestream;  ///< inside the input
};

/// Parses the header of a file. The input may be hostile. Returns `parse_error` if it is malformed, `truncated` if it
/// ends early, `unsupported_format` if it is no JP2 file or codestream, or has more than one component, more than 25
/// bits, more than 2^28 pixels or more than 1024 tiles.
Status read_jpeg2000_header(std::span<const std::uint8_t> file, Jpeg2000Info& info);

/// Decodes a file. `samples` must have the width and height of the header, else it returns `invalid_argument`. With
/// `allow_truncated`, a codestream that ends early (a file received in part) is decoded as far as it goes; without it,
/// that is an error. Returns `codec_failed` if the codestream is damaged, `arena_exhausted` where memory is fixed and
/// runs out. Nothing is printed.
Status decode_jpeg2000(std::span<const std::uint8_t> file, bool allow_truncated, ImageView<std::int32_t> samples);

}  // namespace ilp
