#include "sim/ground/control/control_system.hpp"

#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>

#include "sim/host/gdal_session.hpp"
#include "sim/host/height_units.hpp"
#include "sim/host/longitude.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::control {
namespace {

struct WayCloser {
  void operator()(OGRCoordinateTransformation* way) const { OGRCoordinateTransformation::DestroyCT(way); }
};
using Way = std::unique_ptr<OGRCoordinateTransformation, WayCloser>;

OGRSpatialReference system_named(const std::string& name) {
  OGRSpatialReference system;
  if (system.SetFromUserInput(name.c_str()) != OGRERR_NONE)
    throw std::runtime_error("control points: the coordinate system \"" + name +
                             "\" is not known; a code such as EPSG:32633 expected");
  system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return system;
}

const std::string& name_of_system(const ControlFile& file, const ControlSystem& system) {
  return system.crs.empty() ? file.system : system.crs;
}

void to_degrees(const std::string& from, const std::string& to, ControlFile& file) {
  const OGRSpatialReference metres = system_named(from), degrees = system_named(to);
  constexpr double most_apart_m = 1000;
  if (std::fabs(metres.GetSemiMajor() - degrees.GetSemiMajor()) > most_apart_m)
    throw std::runtime_error("control points: " + from + " belongs to another body than --control-body");
  const Way way(OGRCreateCoordinateTransformation(&metres, &degrees));
  if (!way)
    throw host::gdal_error("control points: coordinates in " + from +
                           " cannot be transformed to longitude and latitude");
  for (ControlPoint& point : file.points) {
    Vec3& p = point.place;
    if (way->Transform(1, &p.x(), &p.y(), &p.z()) == 0 || !p.allFinite())
      throw std::runtime_error("control point " + point.name + " lies outside of " + from +
                               ": check its x and y and the coordinate system");
  }
  file.geographic = true;
  file.system.clear();
}

/// Heights of the geoid above the ellipsoid.
class Geoid {
 public:
  explicit Geoid(const std::string& text) : name_(text) {
    char* end = nullptr;
    const double metres = std::strtod(text.c_str(), &end);
    if (!text.empty() && *end == '\0' && std::isfinite(metres)) {
      constant_ = metres;
      return;
    }
    raster_.reset(GDALDataset::Open(text.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
    const OGRSpatialReference* const system = raster_ ? raster_->GetSpatialRef() : nullptr;
    if (!raster_ || raster_->GetGeoTransform(transform_.data()) != CE_None || transform_[2] != 0 ||
        transform_[4] != 0 || (system != nullptr && system->IsProjected() != 0))
      throw std::runtime_error("--geoid " + text + ": neither metres nor a raster of geoid heights in degrees");
    units_ = host::height_units(text, *raster_);
  }

  [[nodiscard]] double at(const ControlPoint& point) {
    if (constant_) return *constant_;
    const int width = raster_->GetRasterXSize(), height = raster_->GetRasterYSize();
    const double middle = transform_[0] + 0.5 * width * transform_[1];
    const double column = (host::longitude_near(point.place.x(), middle) - transform_[0]) / transform_[1] - 0.5;
    const double row = (point.place.y() - transform_[3]) / transform_[5] - 0.5;
    // A raster around the body goes on behind its last column.
    const bool around = std::fabs(std::fabs(width * transform_[1]) - 360) < 1.5 * std::fabs(transform_[1]);
    const std::string no_height = "--geoid " + name_ + " has no height at control point " + point.name;
    if (!(row >= 0 && row <= height - 1) || (!around && !(column >= 0 && column <= width - 1)))
      throw std::runtime_error(no_height);
    const auto i = static_cast<int>(std::floor(column)), j = std::min(static_cast<int>(row), height - 2);
    const double u = column - i, v = row - j;
    const double between = (1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) +
                           v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1));
    if (!std::isfinite(between)) throw std::runtime_error(no_height);
    return between;
  }

 private:
  /// Not a number where the raster knows none.
  double value(int column, int row) {
    double number = 0;
    const int width = raster_->GetRasterXSize();
    if (raster_->GetRasterBand(1)->RasterIO(GF_Read, (column + width) % width, row, 1, 1, &number, 1, 1, GDT_Float64, 0,
                                            0, nullptr) != CE_None)
      throw host::gdal_error("--geoid " + name_);
    return units_.is_missing(static_cast<float>(number)) ? std::nan("") : units_.metres * number + units_.offset_m;
  }

  std::string name_;
  std::optional<double> constant_;
  host::Dataset raster_;
  host::HeightUnits units_;
  std::array<double, 6> transform_{};
};

bool is_outside(const Mark& mark, double width, double height) {
  return !(mark.pixel.x() >= -0.5 && mark.pixel.y() >= -0.5 && mark.pixel.x() <= width - 0.5 &&
           mark.pixel.y() <= height - 0.5);
}

}  // namespace

bool is_on_earth(const ControlFile& file, const ControlSystem& system) {
  const std::string& name = name_of_system(file, system);
  if (name.empty()) return false;
  const host::GdalSession gdal;
  constexpr double radius_m = 6378137, most_apart_m = 1000;
  return std::fabs(system_named(name).GetSemiMajor() - radius_m) < most_apart_m;
}

void resolve(const ControlSystem& system, ControlFile& file) {
  const std::string name = name_of_system(file, system);
  if (name.empty() && system.geoid.empty()) return;
  const host::GdalSession gdal;
  if (!name.empty()) {
    if (file.geographic)
      throw std::runtime_error("control points in longitude and latitude have no x and y: leave --control-crs out");
    if (system.body_crs.empty())
      throw std::runtime_error("control points in " + name + " need a body: name it with --control-body");
    to_degrees(name, system.body_crs, file);
  }
  if (system.geoid.empty()) return;
  if (!file.geographic)
    throw std::runtime_error("--geoid: the control points have no place on a body; name their --control-crs");
  Geoid geoid(system.geoid);
  for (ControlPoint& point : file.points) point.place.z() += geoid.at(point);
}

void fit_marks(const FlownImages& images, bool original, ControlFile& file) {
  const auto each_outside = [&](auto visit) {
    for (ControlPoint& point : file.points) {
      for (Mark& mark : point.marks) {
        if (images.is_of_flight(mark.image) && is_outside(mark, images.width, images.height)) visit(point, mark);
      }
    }
  };
  bool any = false;
  each_outside([&](const ControlPoint&, const Mark&) { any = true; });
  if (images.binning > 1 && (original || file.original_pixels || any)) {
    for (ControlPoint& point : file.points) {
      // Pixel centres are at integers.
      for (Mark& mark : point.marks) mark.pixel = ((mark.pixel.array() + 0.5) / images.binning - 0.5).matrix();
    }
    file.original_pixels = false;
  }
  each_outside([&](const ControlPoint& point, const Mark& mark) {
    throw std::runtime_error("control point " + point.name + " is marked in " + mark.image + " at column " +
                             host::fixed(mark.pixel.x(), 1) + ", row " + host::fixed(mark.pixel.y(), 1) +
                             ", outside of the image as it flew (" + host::size_text(images.width, images.height) +
                             "): name --flight-info if larger photographs were reduced for the flight");
  });
}

}  // namespace ilp::control
