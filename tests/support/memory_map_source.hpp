// A map source for tests that reads a map in memory. The bytes of the map outlive the source.
#pragma once

#include <algorithm>

#include "hal/maps/map_source.hpp"

namespace ilp {

class MemoryMapSource final : public MapSource {
 public:
  struct Tile {
    MapTilePlace place;
    std::span<const std::uint8_t> file;
  };

  MemoryMapSource() = default;
  MemoryMapSource(std::span<const std::uint8_t> directory, std::span<const Tile> tiles)
      : directory_(directory), tiles_(tiles) {}

  Status read_directory(std::span<std::uint8_t> bytes, std::size_t& size) override {
    return copy(directory_, bytes, size);
  }
  Status read_tile(const MapTilePlace& place, std::span<std::uint8_t> bytes, std::size_t& size) override {
    for (const Tile& tile : tiles_) {
      if (tile.place == place) return copy(tile.file, bytes, size);
    }
    size = 0;
    return StatusCode::not_found;
  }
  [[nodiscard]] std::uint64_t directory_mark() const override {
    return reinterpret_cast<std::uintptr_t>(directory_.data());
  }
  [[nodiscard]] std::span<const std::uint8_t> key() const override { return {}; }

 private:
  static Status copy(std::span<const std::uint8_t> file, std::span<std::uint8_t> bytes, std::size_t& size) {
    size = 0;
    if (file.empty()) return StatusCode::not_found;
    if (file.size() > bytes.size()) {
      return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(file.size()),
              static_cast<std::int64_t>(bytes.size())};
    }
    std::copy(file.begin(), file.end(), bytes.begin());
    size = file.size();
    return {};
  }

  std::span<const std::uint8_t> directory_;
  std::span<const Tile> tiles_;
};

}  // namespace ilp
