#include "sim/ground/landing/landing_files.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <system_error>

#include "sim/ground/export/table.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::landing {
namespace {
namespace fs = std::filesystem;

void write_raster(const host::Raster<float>& values, const char* unit, const std::string& description,
                  const LandingMap& map, const exports::Georeference& place, const fs::path& path) {
  const host::GdalSession gdal;
  fs::path part = path;
  part += ".part";
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", "3");
  host::Dataset file(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(part.c_str(), values.width, values.height,
                                                                              1, GDT_Float32, options.List()));
  if (!file) throw host::gdal_error("cannot write " + path.string());
  std::array<double, 6> transform = exports::geotransform(place, map.hazards.geometry);
  GDALRasterBand* const band = file->GetRasterBand(1);
  std::vector<float> samples = values.samples;
  const bool written = file->SetGeoTransform(transform.data()) == CE_None &&
                       file->SetProjection(place.crs.c_str()) == CE_None &&
                       band->SetNoDataValue(std::numeric_limits<double>::quiet_NaN()) == CE_None &&
                       band->RasterIO(GF_Write, 0, 0, values.width, values.height, samples.data(), values.width,
                                      values.height, GDT_Float32, 0, 0, nullptr) == CE_None;
  band->SetUnitType(unit);
  band->SetDescription(description.c_str());
  CPLErrorReset();
  file.reset();
  if (!written || CPLGetLastErrorType() == CE_Failure) throw host::gdal_error("cannot write " + path.string());
  host::move_into_place(part, path);
}

exports::Shape footprint_of(const LandingSite& site, const LandingMap& map) {
  constexpr int corners = 24;
  const double radius = map.limits.footprint_m / (2 * map.metres_per_unit);
  exports::Shape shape{exports::ShapeKind::polygon, {}};
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    shape.points.emplace_back(site.x + radius * std::cos(angle), site.y + radius * std::sin(angle), site.z);
  }
  return shape;
}

void write_sites(const LandingMap& map, const exports::Georeference& place, const std::string& title,
                 const fs::path& path) {
  using exports::ColumnType;
  exports::Table table{{{"rank", ColumnType::integer},
                        {"safe", ColumnType::real},
                        {"slope_deg", ColumnType::real},
                        {"roughness_m", ColumnType::real},
                        {"step_m", ColumnType::real},
                        {"east_m", ColumnType::real},
                        {"north_m", ColumnType::real},
                        {"height_m", ColumnType::real}},
                       {}};
  std::vector<exports::Shape> shapes;
  for (const LandingSite& site : map.sites) {
    const Vec3 at = place.map_from_world({site.x, site.y, site.z});
    table.rows.push_back({static_cast<std::int64_t>(table.rows.size() + 1), site.safe, site.slope_rad / degree,
                          site.roughness_m, site.step_m, at.x(), at.y(), at.z()});
    shapes.push_back(footprint_of(site, map));
  }
  exports::write_geojson(table, shapes, place, title, path);
}

}  // namespace

StripLanding landing_of(const exports::ExportedStrip& strip, const control::StripControl* control,
                        const LandingLimits& limits) {
  StripLanding landing;
  const std::string name = "strip " + std::to_string(strip.strip.id);
  if (!strip.grid) {
    landing.fault = name + " has no heights";
    return landing;
  }
  const double tilt = control && control->placed ? control->tilt_sigma_rad
                      : strip.strip.frame        ? strip.strip.frame->tilt_sigma_rad
                                                 : 0;
  if (!(tilt > 0)) {
    landing.fault = name +
                    " does not know what is up, so slopes have no meaning: fly with a measured attitude, or name "
                    "control points";
    return landing;
  }
  if (!strip.georeference.in_metres()) {
    landing.fault = name + " is not in metres: fly with an altimeter or a measured position, or name control points";
    return landing;
  }
  try {
    landing.map = assess_landing(*strip.grid, strip.georeference.scale, tilt, limits);
  } catch (const std::runtime_error& error) {
    landing.fault = name + ": " + error.what();
  }
  return landing;
}

std::string line_of(const StripLanding& landing, std::int64_t strip) {
  if (!landing.map) return "Landing sites: none can be found: " + landing.fault;
  const std::string of = " of strip " + std::to_string(strip) + ": ";
  const LandingMap& map = *landing.map;
  if (map.sites.empty()) return "Landing sites" + of + "none is safe with " + host::fixed(100 * least_safe, 1) + " %";
  return "Landing sites" + of + std::to_string(map.sites.size()) + ", the best with a slope of " +
         host::brief(map.sites.front().slope_rad / degree) + " degrees and a step of " +
         host::brief(map.sites.front().step_m) + " m";
}

void export_landing(const LandingMap& map, const fs::path& folder, exports::ExportedStrip& strip) {
  const exports::Georeference& place = strip.georeference;
  host::Raster<float> slope_deg = map.slope_rad;
  for (float& value : slope_deg.samples) value = static_cast<float>(value / degree);
  const auto write = [&](const char* what, const host::Raster<float>& values, const char* unit,
                         const std::string& description) {
    const std::string name = std::string("landing-") + what + strip.suffix + ".tif";
    write_raster(values, unit, description, map, place, folder / name);
    strip.files.push_back(name);
  };
  write("safe", map.safe, "", "probability that a lander is safe here");
  write("slope", slope_deg, "degree", "slope of the plane of the footprint");
  write("roughness", map.hazards.roughness_m, "metre", "rms distance of the ground from the plane of the footprint");
  write("step", map.hazards.step_m, "metre", "highest minus lowest distance of the ground from that plane");
  if (map.sites.empty()) return;
  const std::string name = "landing-sites" + strip.suffix + ".geojson";
  write_sites(map, place, "Landing sites of strip " + std::to_string(strip.strip.id), folder / name);
  strip.files.push_back(name);
}

}  // namespace ilp::landing
