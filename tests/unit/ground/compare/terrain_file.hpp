// Analytic terrains as raster files.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "sim/host/gdal_session.hpp"

namespace ilp::test {

/// Relief of many sizes with slopes of some ten degrees, metres.
inline double hills(double x, double y) {
  return 40 * std::sin(x / 170 + 0.3) * std::cos(y / 140) + 12 * std::sin(x / 37 + y / 61) +
         5 * std::cos(y / 23 - x / 90) + 2 * std::sin(x / 11 + 0.7) * std::sin(y / 13);
}

struct TerrainFile {
  std::array<double, 6> transform{0, 2, 0, 0, 0, -2};  ///< as GDAL has it
  int columns = 300, rows = 240;
  std::string system;  ///< empty: none
  std::string unit = "metre";
  int bands = 1;
  bool declares_missing = true;
};

/// `height` of the coordinates of the file; not a number becomes the declared missing value.
inline void write_terrain(const std::filesystem::path& path, const TerrainFile& file,
                          const std::function<double(double x, double y)>& height) {
  const host::GdalSession gdal;
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const host::Dataset dataset(driver->Create(path.c_str(), file.columns, file.rows, file.bands, GDT_Float32, nullptr));
  auto t = file.transform;
  dataset->SetGeoTransform(t.data());
  if (!file.system.empty()) {
    OGRSpatialReference system;
    system.SetFromUserInput(file.system.c_str());
    dataset->SetSpatialRef(&system);
  }
  constexpr float missing = -9999;
  std::vector<float> row(static_cast<std::size_t>(file.columns));
  for (int band = 1; band <= file.bands; ++band) {
    if (file.declares_missing) dataset->GetRasterBand(band)->SetNoDataValue(double{missing});
    dataset->GetRasterBand(band)->SetUnitType(file.unit.c_str());
    for (int j = 0; j < file.rows; ++j) {
      for (int i = 0; i < file.columns; ++i) {
        const double z = height(t[0] + (i + 0.5) * t[1] + (j + 0.5) * t[2], t[3] + (i + 0.5) * t[4] + (j + 0.5) * t[5]);
        row[static_cast<std::size_t>(i)] = std::isfinite(z) ? static_cast<float>(z) : missing;
      }
      EXPECT_EQ(dataset->GetRasterBand(band)->RasterIO(GF_Write, 0, j, file.columns, 1, row.data(), file.columns, 1,
                                                       GDT_Float32, 0, 0, nullptr),
                CE_None);
    }
  }
}

inline std::vector<float> values_of(const std::filesystem::path& path) {
  const host::GdalSession gdal;
  const host::Dataset file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!file) return {};
  const int columns = file->GetRasterXSize(), rows = file->GetRasterYSize();
  std::vector<float> values(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  EXPECT_EQ(file->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float32, 0,
                                             0, nullptr),
            CE_None);
  return values;
}

}  // namespace ilp::test
