// What the numbers of a raster of heights mean: one rule for all programs that read terrain models of others.
#pragma once

#include <gdal_priv.h>

#include <filesystem>

namespace ilp::host {

/// Height in metres = `metres` * number + `offset_m`, unless the number stands for no height.
struct HeightUnits {
  double metres = 1, offset_m = 0;
  bool missing_declared = false;
  float missing = 0;
  bool plain = true;  ///< no scale and no offset

  /// The declared value. Where none is declared and numbers are heights as they stand, also -9999, -32767 and -32768,
  /// which programs write and forget to declare. Numbers near the largest float, and what is no number.
  [[nodiscard]] bool is_missing(float number) const;
};

/// By scale, offset and unit of the band. Heights that state no unit have that of the coordinate system: metres, or
/// feet on the plane of a country that measures so. std::runtime_error names the file and a unit that is not known.
[[nodiscard]] HeightUnits height_units(const std::filesystem::path& path, GDALDataset& file);

/// Metres per unit of the coordinate system's axes; 1 where it states none.
[[nodiscard]] double metres_per_axis_unit(GDALDataset& file);

}  // namespace ilp::host
