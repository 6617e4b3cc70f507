// Makes pictures of the map that a flight carried, for the pages.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "fsw/maps/map_directory.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "sim/host/raster.hpp"

namespace ilp::fixes {

/// Reads directory.ilpm of a map. Throws std::runtime_error that names the folder and says what is wrong.
void read_map_directory(MapSource& source, const std::filesystem::path& folder, MapDirectory& directory);

class MapImage {
 public:
  /// Throws as read_map_directory does.
  explicit MapImage(const std::filesystem::path& folder);
  [[nodiscard]] std::int64_t id() const { return static_cast<std::int64_t>(directory_->id); }
  /// Grey picture of a rectangle of the map's plane with its north-western corner at (x0_m, y0_m); row 0 is the
  /// northern edge. 0 where no tile has the ground; missing and damaged tiles have none.
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
