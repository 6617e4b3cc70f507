// Converts the numbers of a height raster to metres: one rule for all programs that read terrain models.
#pragma once

#include <gdal_priv.h>

#include <filesystem>

namespace ilp::host {

/// Height in metres = `metres` * number + `offset_m`, unless the number marks a missing height.
struct HeightUnits {
  double metres = 1, offset_m = 0;
  bool missing_declared = false;
  float missing = 0;  ///< the declared number for a missing height
  bool plain = true;  ///< no scale and no offset

  /// True for NaN, for magnitudes of 1e30 and more, and for the declared number. If none is declared and `plain` is
  /// set, also for -9999, -32767 and -32768, which programs write and forget to declare.
  [[nodiscard]] bool is_missing(float number) const;
};

/// Reads scale, offset and unit of the first band. Heights without a unit have the linear unit of a projected
/// coordinate system, else metres. Throws std::runtime_error that names the file, for an unknown unit or a scale of 0.
[[nodiscard]] HeightUnits height_units(const std::filesystem::path& path, GDALDataset& file);

/// Metres per unit of the coordinate system's axes; 1 if no unit is stated, and for coordinates in degrees.
[[nodiscard]] double metres_per_axis_unit(GDALDataset& file);

}  // namespace ilp::host
