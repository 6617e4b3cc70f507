// The quality layers of a product: their number, their sizes, and the record after layers were cut off.
#pragma once

#include "fsw/records/records.hpp"

namespace ilp {

/// Number of layers. A product that was made without layers, or whose layer sizes are not on record, counts as one
/// layer.
[[nodiscard]] int layers_of(const ProductRecord& product);
/// Size of the file with the first `layers` layers, in bytes.
[[nodiscard]] std::uint32_t bytes_to(const ProductRecord& product, int layers);
/// The ground has confirmed every layer.
[[nodiscard]] bool all_held(const ProductRecord& product);
/// Updates the record of a product whose file has been cut to its first `layers` layers and `bytes` bytes.
void keep_layers(int layers, std::size_t bytes, ProductRecord& product);

}  // namespace ilp
