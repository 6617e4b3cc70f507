// What a flight has computed, in one line per keyframe: two flights that computed the same have the same lines.
#pragma once

#include <string>
#include <vector>

#include "hal/store/store.hpp"

namespace ilp::store_tool {

/// Lines `keyframe K frame F time_ns T | keyframe pose structure depth richness | depth-product image-product`, each
/// part the CRC-32 of the record's fields in serial form, `-` where there is none; then one over all keyframes and one
/// over all products. Left out is the work of the link and of the storage manager: blobs that they release, the state
/// of products. A product counts by the CRC-32 of its bytes on record. If the bytes are still held and have another
/// CRC-32, the part is `damaged`. The record of a product is gone after the ground has confirmed the product. A fault
/// of the store is an exception.
[[nodiscard]] std::vector<std::string> keyframe_lines(Store& store);

}  // namespace ilp::store_tool
