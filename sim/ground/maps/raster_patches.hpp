// Makes the patches of a map from an orbiter's rasters: an orthoimage and a terrain model in any projections.
#pragma once

#include <filesystem>

#include "sim/ground/maps/map_patches.hpp"
#include "sim/ground/maps/map_projection.hpp"
#include "sim/host/raster_band.hpp"

namespace ilp::maps {

/// A rectangle in metres of a map's plane or in degrees.
struct Extent {
  double west = 0, south = 0, east = 0, north = 0;

  [[nodiscard]] bool empty() const { return !(west < east && south < north); }
  [[nodiscard]] Place middle() const { return {(west + east) / 2, (south + north) / 2}; }
};
/// The intersection.
[[nodiscard]] Extent common_part(const Extent& a, const Extent& b);

/// A raster file that is resampled on the map's plane.
class MappedRaster {
 public:
  /// Throws std::runtime_error that names the file.
  MappedRaster(std::filesystem::path path, host::RasterBand::Content content);

  [[nodiscard]] const host::RasterBand& band() const { return band_; }
  [[nodiscard]] Body body() const;
  /// Longitude and latitude of the raster's middle in degrees; x and y for Body::none.
  [[nodiscard]] Place middle() const;
  /// Sets the plane for the functions below.
  void lay_on(const MapPlane& plane);
  /// Bounding rectangle of the raster on the plane.
  [[nodiscard]] Extent extent() const;
  /// Pixel size on the ground at the raster's middle, m; the smaller of both directions.
  [[nodiscard]] double pixel_m() const;

  /// Means over squares of side `box_m` centred on a grid of the plane: (first.x + i * spacing_m, first.y - j *
  /// spacing_m). NaN if less than half of a square is known. Throws std::runtime_error if the grid contains a pole and
  /// the raster is in degrees or in a cylindrical projection.
  [[nodiscard]] host::Raster<float> means(Place first, double spacing_m, std::int32_t columns, std::int32_t rows,
                                          double box_m);

 private:
  struct Nodes;
  /// Column and row in the file of a point of the plane, pixel centres at integers. If longitudes run along the
  /// columns, the column is shifted by full turns to be nearest to `near_column`.
  [[nodiscard]] std::optional<Place> pixel_at(Place map, double near_column) const;
  /// Number of columns in 360 degrees if longitudes run along the columns (in degrees and in cylindrical projections);
  /// otherwise 0.
  [[nodiscard]] double columns_of_turn() const;
  [[nodiscard]] double middle_column() const { return (band_.columns() - 1) / 2.0; }
  [[nodiscard]] double middle_row() const { return (band_.rows() - 1) / 2.0; }
  /// As host::RasterBand::read. If the raster goes around the body, `x` may be any column, and `factor` must divide the
  /// number of columns.
  [[nodiscard]] host::Raster<float> cells(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                                          std::int32_t factor);
  [[nodiscard]] Place raster_place(double column, double row) const;
  [[nodiscard]] Nodes nodes_of(Place first, double spacing_m, std::int32_t columns, std::int32_t rows) const;

  host::RasterBand band_;
  std::optional<RasterFromMap> from_map_;
  double turn_px_ = 0;   ///< columns_of_turn()
  bool around_ = false;  ///< the raster goes around the body: the first column follows the last
};

/// Makes patches from an image and heights. The light is the image divided by its mean in `area`.
class RasterPatches {
 public:
  /// The rasters must outlive the object. Throws std::runtime_error if the image has no known pixel in the area.
  RasterPatches(MappedRaster& image, MappedRaster& heights, const Extent& area);

  [[nodiscard]] MapPatch operator()(const MapLayer& layer, const PatchArea& area);

 private:
  MappedRaster& image_;
  MappedRaster& heights_;
  double mean_ = 1;
};

}  // namespace ilp::maps
