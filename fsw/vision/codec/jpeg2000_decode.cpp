#include "fsw/vision/codec/jpeg2000_decode.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/vision/codec/jp2_file.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"

namespace ilp {

Status read_jpeg2000_header(std::span<const std::uint8_t> file, Jpeg2000Info& info) {
  return parse_jp2(file, info);
}

Status decode_jpeg2000(std::span<const std::uint8_t> file, bool allow_truncated, ImageView<std::int32_t> samples) {
  Jpeg2000Info info;
  ILP_TRY(parse_jp2(file, info));
  if (samples.width != info.width || samples.height != info.height) {
    return out_of_range(Argument::image_size, samples.width);
  }
  Decoding decoding{samples.width, samples.height, allow_truncated, 0, nullptr, &samples};
  decoding.take = [](ImageView<const std::int32_t> decoded, void* to) {
    const auto& copy = *static_cast<const ImageView<std::int32_t>*>(to);
    for (std::int32_t y = 0; y < copy.height; ++y) std::copy_n(decoded.row(y), copy.width, copy.row(y));
  };
  return openjpeg_decode(info.codestream, decoding);
}

}  // namespace ilp
