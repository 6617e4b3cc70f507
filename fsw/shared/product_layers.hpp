// The quality layers of a product: how many there are to send, and what remains when some are cut off.
#pragma once

#include "fsw/records/records.hpp"

namespace ilp {

/// Products that were made without layers, or whose sizes are not on record, are one layer.
[[nodiscard]] int layers_of(const ProductRecord& product);
/// Size of the file with the first `layers` layers.
[[nodiscard]] std::uint32_t bytes_to(const ProductRecord& product, int layers);
/// The ground has confirmed every layer.
[[nodiscard]] bool all_held(const ProductRecord& product);
/// Updates the record of a product whose file has been cut to its first `layers` layers, `bytes` in all.
void keep_layers(int layers, std::size_t bytes, ProductRecord& product);

}  // namespace ilp
