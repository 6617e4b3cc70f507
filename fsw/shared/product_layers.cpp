#include "fsw/shared/product_layers.hpp"

namespace ilp {

int layers_of(const ProductRecord& product) {
  const bool known = product.layers >= 1 && product.layers <= limits::max_quality_layers &&
                     product.layer_bytes[product.layers - 1] == product.bytes;
  return known ? product.layers : 1;
}

std::uint32_t bytes_to(const ProductRecord& product, int layers) {
  return layers >= layers_of(product) ? product.data.bytes : product.layer_bytes[layers - 1];
}

bool all_held(const ProductRecord& product) {
  const auto wanted = (1U << static_cast<unsigned>(layers_of(product))) - 1;
  return (product.layers_held & wanted) == wanted;
}

void keep_layers(int layers, std::size_t bytes, ProductRecord& product) {
  for (int i = layers; i < product.layers; ++i) {
    product.layer_bytes[i] = 0;
    product.layer_quality[i] = 0;
  }
  product.layers = static_cast<std::uint8_t>(layers);
  product.bytes = static_cast<std::uint32_t>(bytes);
}

}  // namespace ilp
