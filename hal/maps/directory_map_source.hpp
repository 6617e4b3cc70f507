// Reads and writes a map in a folder, as `ilp-ground map-tiles` makes it. The folder holds `directory.ilpm`, and
// `tile-LAYER-ROW-COLUMN.ilpt` for each tile, with four digits for row and column.
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/maps/map_source.hpp"

namespace ilp {

/// Capacity for the name of a map's file, with its extension.
inline constexpr std::size_t max_map_file_name = 32;
using MapFileName = FixedText<max_map_file_name>;
inline constexpr const char* map_directory_name = "directory.ilpm";
[[nodiscard]] MapFileName map_tile_name(const MapTilePlace& place);

class DirectoryMapSource final : public MapFolder {
 public:
  /// Sets the folder, which need not exist yet. Returns `capacity_exceeded` if a file's path would exceed
  /// limits::max_path_bytes.
  Status open(const char* folder);
  /// Whether the map's directory exists at present. Directory and tiles may arrive later.
  [[nodiscard]] bool has_directory() const;
  /// Sets the key with which the directory must be signed; it outlives the source. Empty: no signature is needed.
  void require_key(std::span<const std::uint8_t> key) { key_ = key; }

  Status read_directory(std::span<std::uint8_t> bytes, std::size_t& size) override;
  Status read_tile(const MapTilePlace& place, std::span<std::uint8_t> bytes, std::size_t& size) override;
  [[nodiscard]] std::uint64_t directory_mark() const override;
  [[nodiscard]] std::span<const std::uint8_t> key() const override { return key_; }
  /// write_directory() and write_tile() make the folder if it is missing.
  Status write_directory(std::span<const std::uint8_t> bytes) override;
  Status write_tile(const MapTilePlace& place, std::span<const std::uint8_t> bytes) override;
  Status erase_tile(const MapTilePlace& place) override;

 private:
  using Path = FixedText<limits::max_path_bytes>;
  [[nodiscard]] Path path_of(const char* name, const char* end = "") const;
  Status read_file(const char* name, std::span<std::uint8_t> bytes, std::size_t& size) const;
  Status write_file(const char* name, std::span<const std::uint8_t> bytes) const;

  FixedText<limits::max_path_bytes> folder_;
  std::span<const std::uint8_t> key_;
};

}  // namespace ilp
