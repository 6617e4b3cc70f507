// Digests of what a flight has computed, a line per keyframe. Flights with the same results have the same lines.
#pragma once

#include <string>
#include <vector>

#include "hal/store/store.hpp"

namespace ilp::store_tool {

/// A line is `keyframe K frame F time_ns T | keyframe pose structure depth mask richness | depth-product
/// image-product`. Each of these parts is the CRC-32 of the record's fields in serial form, or `-` without a record.
/// The last line has a CRC-32 over all keyframes and one over all products. Blobs and the state of products are left
/// out, because the link and the storage manager change them. The record of a product contains the CRC-32 of its bytes;
/// if the bytes are still stored and have another CRC-32, the part is `damaged`. A product has no record after the
/// ground has confirmed it. Throws std::runtime_error for a fault of the store.
[[nodiscard]] std::vector<std::string> keyframe_lines(Store& store);

}  // namespace ilp::store_tool
