// Sizes and byte views of the blobs of a place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/vision/place/place_features.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp {

/// Bytes per feature in the blob, which has all features first and then the inverse depths of their ground.
inline constexpr std::size_t bytes_per_feature = sizeof(PlaceFeature) + sizeof(float);

/// Number of cells, and of bytes in the blob: one per cell.
inline std::size_t cell_count(const SeenCells& cells) {
  return static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows);
}

template <typename T>
std::span<const std::uint8_t> octets(const T* items, std::size_t count) {
  return {reinterpret_cast<const std::uint8_t*>(items), count * sizeof(T)};
}
template <typename T>
std::span<std::uint8_t> writable_octets(T* items, std::size_t count) {
  return {reinterpret_cast<std::uint8_t*>(items), count * sizeof(T)};
}

}  // namespace ilp
