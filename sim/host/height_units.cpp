#include "sim/host/height_units.hpp"

#include <ogr_spatialref.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <string>

namespace ilp::host {
namespace {

double metres_per_height_unit(const std::filesystem::path& path, std::string unit, double axis_unit_m) {
  std::transform(unit.begin(), unit.end(), unit.begin(), [](unsigned char c) { return std::tolower(c); });
  if (unit.empty()) return axis_unit_m;
  for (const char* name : {"m", "metre", "meter", "metres", "meters", "strip unit"}) {
    if (unit == name) return 1;
  }
  for (const char* name : {"km", "kilometre", "kilometer", "kilometres", "kilometers"}) {
    if (unit == name) return 1000;
  }
  if (unit == "cm" || unit == "centimetre" || unit == "centimeter") return 0.01;
  if (unit == "ft" || unit == "foot" || unit == "feet" || unit == "international foot") return 0.3048;
  for (const char* name : {"us survey foot", "ftus", "us-ft", "us_survey_foot", "foot_us", "sft"}) {
    if (unit == name) return 1200.0 / 3937;
  }
  throw std::runtime_error(path.string() + ": heights in the unit \"" + unit +
                           "\"; metres, kilometres or feet expected");
}

}  // namespace

bool HeightUnits::is_missing(float number) const {
  // Programs of planetary mapping mark missing values by numbers near the largest float, declared or not.
  constexpr float no_height = 1e30F;
  if (!(std::fabs(number) < no_height)) return true;
  if (missing_declared) return number == missing;
  return plain && (number == -9999.0F || number == -32767.0F || number == -32768.0F);
}

double metres_per_axis_unit(GDALDataset& file) {
  const OGRSpatialReference* const system = file.GetSpatialRef();
  if (system == nullptr || system->IsEmpty() != 0 || system->IsGeographic() != 0) return 1;
  const double unit = system->GetLinearUnits();
  return std::isfinite(unit) && unit > 0 ? unit : 1;
}

HeightUnits height_units(const std::filesystem::path& path, GDALDataset& file) {
  GDALRasterBand& band = *file.GetRasterBand(1);
  const OGRSpatialReference* const system = file.GetSpatialRef();
  // Only a plane of feet says something about heights; a strip's own axes have units of their own.
  const bool projected = system != nullptr && system->IsProjected() != 0;
  const double unit = metres_per_height_unit(path, band.GetUnitType(), projected ? metres_per_axis_unit(file) : 1);
  const double scale = band.GetScale(), offset = band.GetOffset();
  HeightUnits units;
  units.metres = unit * scale;
  units.offset_m = unit * offset;
  units.plain = scale == 1 && offset == 0;
  int declared = 0;
  units.missing = static_cast<float>(band.GetNoDataValue(&declared));
  units.missing_declared = declared != 0;
  if (!(std::isfinite(units.metres) && units.metres != 0 && std::isfinite(units.offset_m)))
    throw std::runtime_error(path.string() + ": a scale or an offset of the heights that is no number");
  return units;
}

}  // namespace ilp::host
