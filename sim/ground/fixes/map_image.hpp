// The image of the map that a flight carried, for pages.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "fsw/maps/map_directory.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "sim/host/raster.hpp"

namespace ilp::fixes {

/// Reads directory.ilpm of a map. std::runtime_error names the folder and what is wrong.
void read_map_directory(MapSource& source, const std::filesystem::path& folder, MapDirectory& directory);

class MapImage {
 public:
  /// std::runtime_error as read_map_directory.
  explicit MapImage(const std::filesystem::path& folder);
  [[nodiscard]] std::int64_t id() const { return static_cast<std::int64_t>(directory_->id); }
  /// Of the map's plane, row 0 in the north: from x0_m, y0_m in the north-west on, m. 0 where no tile knows the ground;
  /// a tile that is missing or damaged knows none.
  [[nodiscard]] host::Raster<std::uint8_t> picture(double x0_m, double y0_m, double pixel_m, std::int32_t width,
                                                   std::int32_t height);

 private:
  struct Scratch;
  void paint(std::size_t entry, double x0_m, double y0_m, double pixel_m, Scratch& scratch,
             host::Raster<std::uint8_t>& picture);

  DirectoryMapSource source_;
  std::unique_ptr<MapDirectory> directory_;
};

}  // namespace ilp::fixes
