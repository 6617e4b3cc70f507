// Interfaces to the files of a map: one directory, and one file for each tile. Localisation reads them (MapSource);
// updates from the ground are written into them (MapFolder). These interfaces carry bytes, which fsw/maps decodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// Layer of a tile, and its row and column in the layer.
struct MapTilePlace {
  std::uint16_t layer = 0, row = 0, column = 0;

  friend bool operator==(const MapTilePlace&, const MapTilePlace&) = default;
};

/// Every call takes a bounded time. Reading writes the complete file to the first `size` bytes of `bytes`; after an
/// error `size` is 0.
class MapSource {
 public:
  /// Reads the map's directory. Returns `not_found` if there is no map, `capacity_exceeded` (first value: bytes of the
  /// file) if `bytes` is too small, `io_error` (first value: errno) if the file cannot be read.
  virtual Status read_directory(std::span<std::uint8_t> bytes, std::size_t& size) = 0;
  /// Reads a tile with the same statuses; `not_found` also if the tile has not arrived yet.
  virtual Status read_tile(const MapTilePlace& place, std::span<std::uint8_t> bytes, std::size_t& size) = 0;
  /// A number that changes when this or another process replaces the directory; 0: there is none.
  [[nodiscard]] virtual std::uint64_t directory_mark() const = 0;
  /// The key with which the directory must be signed; empty: no signature is needed.
  [[nodiscard]] virtual std::span<const std::uint8_t> key() const = 0;

 protected:
  ~MapSource() = default;
};

/// A map that can be changed. After a power cut or an error a file has its new or its previous content. The calls
/// return `io_error` (first value: errno) if a file cannot be changed.
class MapFolder : public MapSource {
 public:
  virtual Status write_directory(std::span<const std::uint8_t> bytes) = 0;
  virtual Status write_tile(const MapTilePlace& place, std::span<const std::uint8_t> bytes) = 0;
  /// Returns ok also if there is no such tile.
  virtual Status erase_tile(const MapTilePlace& place) = 0;

 protected:
  ~MapFolder() = default;
};

}  // namespace ilp
