// The ground of a map from an orbiter's rasters: an orthoimage and a terrain model in any projections.
#pragma once

#include <filesystem>

#include "sim/ground/maps/map_patches.hpp"
#include "sim/ground/maps/map_projection.hpp"
#include "sim/host/raster_band.hpp"

namespace ilp::maps {

/// West, south, east, north; metres of a map's plane or degrees.
struct Extent {
  double west = 0, south = 0, east = 0, north = 0;

  [[nodiscard]] bool empty() const { return !(west < east && south < north); }
  [[nodiscard]] Place middle() const { return {(west + east) / 2, (south + north) / 2}; }
};
[[nodiscard]] Extent common_part(const Extent& a, const Extent& b);

/// A raster on the map's plane.
class MappedRaster {
 public:
  /// std::runtime_error names the file.
  MappedRaster(std::filesystem::path path, host::RasterBand::Content content);

  [[nodiscard]] const host::RasterBand& band() const { return band_; }
  [[nodiscard]] Body body() const;
  /// Longitude and latitude of its middle, in degrees (on no body: x and y).
  [[nodiscard]] Place middle() const;
  /// From now on places are those of this plane.
  void lay_on(const MapPlane& plane);
  /// What it covers of the plane: a rectangle about it.
  [[nodiscard]] Extent extent() const;
  /// Metres on the ground from one pixel to the next at its middle, the smaller of both directions.
  [[nodiscard]] double pixel_m() const;

  /// Means over squares of `box_m` about places of the plane: (x + i spacing, y - j spacing). NaN where less than half
  /// of a square is known. std::runtime_error where the longitudes of a raster in degrees or in a cylindrical
  /// projection meet at a pole between them.
  [[nodiscard]] host::Raster<float> means(Place first, double spacing_m, std::int32_t columns, std::int32_t rows,
                                          double box_m);

 private:
  struct Nodes;
  /// Column and row of the file, pixel centres at integers. Where longitudes run along the columns, the turn counts
  /// that comes nearest to `near_column`.
  [[nodiscard]] std::optional<Place> pixel_at(Place map, double near_column) const;
  /// Of 360 degrees, where longitudes run along the columns: in degrees and in cylindrical projections. Otherwise 0.
  [[nodiscard]] double columns_of_turn() const;
  [[nodiscard]] double middle_column() const { return (band_.columns() - 1) / 2.0; }
  [[nodiscard]] double middle_row() const { return (band_.rows() - 1) / 2.0; }
  /// As host::RasterBand::read. Where the raster goes around the body, from any column on, and `factor` divides the
  /// number of columns.
  [[nodiscard]] host::Raster<float> cells(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                                          std::int32_t factor);
  [[nodiscard]] Place raster_place(double column, double row) const;
  [[nodiscard]] Nodes nodes_of(Place first, double spacing_m, std::int32_t columns, std::int32_t rows) const;

  host::RasterBand band_;
  std::optional<RasterFromMap> from_map_;
  double turn_px_ = 0;   ///< columns_of_turn()
  bool around_ = false;  ///< behind the last column comes the first one
};

/// Both rasters as pieces of a map. The light is that of the image over its mean in `area`.
class RasterPatches {
 public:
  /// std::runtime_error if the image knows nothing in the area.
  RasterPatches(MappedRaster& image, MappedRaster& heights, const Extent& area);

  [[nodiscard]] MapPatch operator()(const MapLayer& layer, const PatchArea& area);

 private:
  MappedRaster& image_;
  MappedRaster& heights_;
  double mean_ = 1;
};

}  // namespace ilp::maps
