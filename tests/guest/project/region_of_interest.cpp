// region_of_interest IMAGE.pgm OUT.jp2: the middle of the image exactly, the rest in what is left of 1 bit per pixel.
#include <cstdlib>
#include <memory>

#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "guest.hpp"

int main(int count, char** names) {
  if (count != 3) return 2;
  auto image = read_pgm(names[1]);
  Picture<std::uint8_t> mask(image.width, image.height);
  for (int y = image.height / 3; y < image.height / 2; ++y) {
    for (int x = image.width / 3; x < image.width / 2; ++x) mask.view().at(x, y) = 255;
  }
  ilp::Jpeg2000Params params{
      .max_bytes = image.pixels.size() / 8, .region = ilp::RegionCoding::drop_background, .lossless = true};
  const auto workspace = std::make_unique<ilp::Jpeg2000Workspace>();
  std::vector<std::uint8_t> file(params.max_bytes);
  ilp::Jpeg2000Product product;
  check(ilp::encode_jpeg2000(image.view(), mask.view(), params, {}, *workspace, file, product), "encoding");
  std::ofstream(names[2], std::ios::binary)
      .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(product.bytes));

  Picture<std::int32_t> decoded(image.width, image.height);
  check(ilp::decode_jpeg2000({file.data(), product.bytes}, false, decoded.view()), "decoding");
  std::size_t inside = 0, wrong = 0;
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    if (mask.pixels[i] == 0) continue;
    ++inside;
    if (decoded.pixels[i] != image.pixels[i]) ++wrong;
  }
  std::printf("%zu bytes; of %zu pixels of the region %zu are not exact\n", product.bytes, inside, wrong);
  return wrong == 0 ? 0 : 1;
}
