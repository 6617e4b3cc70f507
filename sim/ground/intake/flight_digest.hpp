// What a flight has computed, in one line per keyframe: two flights that computed the same have the same lines.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::intake {

/// Lines `keyframe K frame F time_ns T | keyframe pose structure depth richness | depth-product image-product`, each
/// part the CRC-32 of the record's fields in serial form, `-` where there is none; then one over all keyframes and one
/// over all products; then one for every table of what is computed per flight, frame or strip. The digest leaves
/// out the work of the link and of the storage manager: blobs that they release, the state of products. A product
/// counts by the CRC-32 of its bytes on record. If the bytes are still held and have another CRC-32, the part is
/// `damaged`. The record of a product is gone after the ground has confirmed the product. Nothing is written to the
/// database; std::runtime_error when it cannot be read.
[[nodiscard]] std::vector<std::string> flight_digest(const std::filesystem::path& database);

}  // namespace ilp::intake
