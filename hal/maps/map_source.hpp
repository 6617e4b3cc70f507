// Where the files of a map lie: one directory, and one file for each tile. They are bytes here; fsw/maps reads them.
// Whoever localises reads them (MapSource); what comes from the ground is written beside them (MapFolder).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// Row and column of a tile in a layer of the map.
struct MapTilePlace {
  std::uint16_t layer = 0, row = 0, column = 0;

  friend bool operator==(const MapTilePlace&, const MapTilePlace&) = default;
};

/// Every call is bounded, and fills `bytes` with the whole file or nothing; `size` is its length.
class MapSource {
 public:
  /// `not_found`: there is no map; `capacity_exceeded` (a = bytes of the file) if `bytes` is too small; `io_error`
  /// (a = errno).
  virtual Status read_directory(std::span<std::uint8_t> bytes, std::size_t& size) = 0;
  /// The same for a tile, which may have not come yet.
  virtual Status read_tile(const MapTilePlace& place, std::span<std::uint8_t> bytes, std::size_t& size) = 0;
  /// Another number once the directory was replaced, also by another process.
  [[nodiscard]] virtual std::uint64_t directory_mark() const = 0;
  /// With which the directory must be signed; empty: it need not be.
  [[nodiscard]] virtual std::span<const std::uint8_t> key() const = 0;

 protected:
  ~MapSource() = default;
};

/// A file is there whole or as it was before, also after a power cut. `io_error` (a = errno).
class MapFolder : public MapSource {
 public:
  virtual Status write_directory(std::span<const std::uint8_t> bytes) = 0;
  virtual Status write_tile(const MapTilePlace& place, std::span<const std::uint8_t> bytes) = 0;
  /// ok where there is none.
  virtual Status erase_tile(const MapTilePlace& place) = 0;

 protected:
  ~MapFolder() = default;
};

}  // namespace ilp
