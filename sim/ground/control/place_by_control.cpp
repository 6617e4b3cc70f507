#include "sim/ground/control/place_by_control.hpp"

#include <ogr_spatialref.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/control/control_fit.hpp"
#include "sim/ground/intake/move_keyframe.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/longitude.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::control {
namespace {

struct Middle {
  double longitude_deg = 0, latitude_deg = 0;
};

/// Places in metres: as the file has them, or east and north of the middle in a transverse Mercator projection.
class Places {
 public:
  Places(const ControlFile& file, const std::string& crs) {
    for (const ControlPoint& point : file.points) metres_[point.name] = point.place;
    if (!file.geographic) return;
    if (crs.empty()) {
      throw std::runtime_error(
          "control points in longitude and latitude need a body: name it with --control-body, or give x and y");
    }
    std::vector<double> longitudes;
    for (const ControlPoint& point : file.points) {
      longitudes.push_back(point.place.x());
      middle_.latitude_deg += point.place.y() / static_cast<double>(file.points.size());
    }
    middle_.longitude_deg = host::longitude_arc(longitudes).middle_deg();
    project(crs);
  }
  [[nodiscard]] const Middle& middle() const { return middle_; }
  [[nodiscard]] const Vec3& of(const std::string& name) const { return metres_.at(name); }

 private:
  void project(const std::string& crs) {
    const host::GdalSession gdal;
    OGRSpatialReference degrees, metres;
    if (degrees.SetFromUserInput(crs.c_str()) != OGRERR_NONE)
      throw host::gdal_error("GDAL does not know the coordinate system " + crs);
    metres.SetProjCS("about the middle of the control points");
    metres.CopyGeogCSFrom(&degrees);
    metres.SetTM(middle_.latitude_deg, middle_.longitude_deg, 1, 0, 0);
    degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    metres.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    OGRCoordinateTransformation* const way = OGRCreateCoordinateTransformation(&degrees, &metres);
    if (way == nullptr) throw host::gdal_error("GDAL cannot make a projection about the control points");
    for (auto& [name, place] : metres_) {
      if (way->Transform(1, &place.x(), &place.y()) == 0) place.setConstant(std::nan(""));
    }
    OGRCoordinateTransformation::DestroyCT(way);
  }

  std::map<std::string, Vec3> metres_;
  Middle middle_;
};

std::map<std::string, const intake::Keyframe*> posed_keyframes(const intake::Flight& flight,
                                                               const intake::Strip& strip) {
  std::map<std::string, const intake::Keyframe*> keyframes;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (keyframe.posed()) keyframes[host::image_key(keyframe.name)] = &keyframe;
  }
  return keyframes;
}

std::vector<Sight> sights_of(const ControlPoint& point,
                             const std::map<std::string, const intake::Keyframe*>& keyframes) {
  std::vector<Sight> sights;
  for (const Mark& mark : point.marks) {
    const auto found = keyframes.find(host::image_key(mark.image));
    if (found == keyframes.end()) continue;
    const PoseRecord& pose = *found->second->pose;
    sights.push_back({found->second->camera, rotation_from_quaternion(pose.q_cam_from_world),
                      Vec3(pose.centre[0], pose.centre[1], pose.centre[2]), mark.pixel});
  }
  return sights;
}

constexpr double most_rms_px = 10;

struct Measured {
  std::vector<PointResult> results;
  std::vector<Surveyed> surveyed;      ///< those that could be triangulated
  std::vector<std::size_t> result_of;  ///< index in `results`
};

Measured measure(const ControlFile& file, const Places& places, const intake::Flight& flight,
                 const intake::Strip& strip) {
  Measured measured;
  const auto keyframes = posed_keyframes(flight, strip);
  for (const ControlPoint& point : file.points) {
    const std::vector<Sight> sights = sights_of(point, keyframes);
    if (sights.empty()) continue;
    PointResult result;
    result.name = point.name;
    result.check = point.check;
    result.marks = sights.size();
    const auto found = triangulate(sights);
    if (!found) {
      result.fault = sights.size() < 2 ? "it is marked in one posed keyframe only"
                                       : "its lines of sight are nearly parallel or meet behind a camera";
    } else {
      result.rms_px = found->rms_px;
      if (found->rms_px > most_rms_px) {
        result.fault = "its marks do not show one point: " + host::brief(found->rms_px) + " px apart";
      }
      measured.surveyed.push_back({found->point, found->covariance, places.of(point.name), point.sigma_m,
                                   !point.check && result.fault.empty()});
      measured.result_of.push_back(measured.results.size());
    }
    measured.results.push_back(std::move(result));
  }
  return measured;
}

void report_residuals(const ControlFit& fit, const Measured& measured, StripControl& control) {
  double used = 0, checked = 0;
  for (std::size_t i = 0; i < measured.surveyed.size(); ++i) {
    PointResult& result = control.points[measured.result_of[i]];
    result.residual = fit.residual[i];
    result.expected_m = fit.expected[i];
    result.used = fit.used[i];
    const double error = fit.residual[i].norm();
    if (result.used) {
      used += error * error;
      ++control.used;
    } else if (result.check && result.fault.empty()) {
      checked += error * error;
      ++control.checked;
    } else if (result.fault.empty()) {
      result.fault = "it lies " + host::brief(error) + " m from where the others put it, one sigma is " +
                     host::brief(result.expected_m) + " m";
    }
  }
  control.used_rmse_m = std::sqrt(used / static_cast<double>(control.used));
  control.check_rmse_m = control.checked > 0 ? std::sqrt(checked / static_cast<double>(control.checked)) : std::nan("");
}

/// By how well the used points agree in height, and by their scatter: about their middle, and across their longest
/// line.
void state_errors(const ControlFit& fit, const Measured& measured, intake::ControlPlace& place) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, squares = 0, expected = 0;
  for (std::size_t i = 0; i < measured.surveyed.size(); ++i) {
    if (!fit.used[i]) continue;
    const Vec3& at = measured.surveyed[i].place;
    n += 1;
    x += at.x();
    y += at.y();
    xx += at.x() * at.x();
    xy += at.x() * at.y();
    yy += at.y() * at.y();
    squares += fit.residual[i].z() * fit.residual[i].z();
    expected += fit.expected[i] * fit.expected[i] / 3;
  }
  const double a = xx - x * x / n, b = xy - x * y / n, c = yy - y * y / n;
  const double across = 0.5 * (a + c - std::sqrt((a - c) * (a - c) + 4 * b * b));
  // Three points agree with any plane: then what survey and marks explain counts alone.
  const double variance = std::max(n > 3 ? squares / (n - 3) : 0.0, expected / n);
  place.height_sigma_m = std::sqrt(variance / n);
  if (a + c > 0) place.scale_sigma = std::sqrt(variance / (a + c));
  if (across > 0) place.tilt_sigma_rad = std::sqrt(variance / across);
}

void move_strip(const host::Similarity3& by, const intake::Strip& strip, intake::Flight& flight) {
  Similarity similarity;
  similarity.rotation = by.rotation;
  similarity.translation = by.translation;
  similarity.scale = by.scale;
  for (const std::int64_t id : strip.keyframes) {
    intake::Keyframe& keyframe = flight.keyframes.at(id);
    intake::move(similarity, keyframe);
    if (keyframe.pose) keyframe.pose->scale_source = ScaleSource::navigation;
  }
}

}  // namespace

std::vector<StripControl> place_by_control(const ControlFile& file, Body body, const std::string& crs,
                                           intake::Flight& flight) {
  const Places places(file, crs);
  std::vector<StripControl> all;
  for (auto& [id, strip] : flight.strips) {
    Measured measured = measure(file, places, flight, strip);
    if (measured.results.empty()) continue;
    StripControl control;
    control.strip = id;
    control.points = measured.results;
    const auto fit = fit_control(measured.surveyed);
    if (fit) {
      report_residuals(*fit, measured, control);
      control.placed = true;
      control.metres_per_unit = fit->place_from_world.scale;
      move_strip(fit->place_from_world, strip, flight);
      intake::ControlPlace& place = strip.control.emplace();
      place.body = file.geographic ? body : Body::none;
      place.longitude_deg = places.middle().longitude_deg;
      place.latitude_deg = places.middle().latitude_deg;
      state_errors(*fit, measured, place);
      control.tilt_sigma_rad = place.tilt_sigma_rad;
      strip.map.reset();
    } else {
      control.fault = "no three of its control points that are not in one line agree";
    }
    all.push_back(std::move(control));
  }
  return all;
}

std::vector<std::string> lines_of(const std::vector<StripControl>& strips) {
  std::vector<std::string> lines;
  if (strips.empty()) lines.emplace_back("Control points: none of them is marked in a posed keyframe");
  for (const StripControl& strip : strips) {
    const std::string name = "Control points of strip " + std::to_string(strip.strip) + ": ";
    if (!strip.placed) {
      lines.push_back(name + "the strip was not placed: " + strip.fault);
    } else {
      lines.push_back(name + std::to_string(strip.used) + " used, RMSE " + host::brief(strip.used_rmse_m) + " m" +
                      (strip.checked > 0 ? "; " + host::counted(strip.checked, "check point") + ", RMSE " +
                                               host::brief(strip.check_rmse_m) + " m"
                                         : "; no check point"));
    }
    for (const PointResult& point : strip.points) {
      if (!point.fault.empty()) lines.push_back("Control point " + point.name + " is not used: " + point.fault);
    }
  }
  return lines;
}

}  // namespace ilp::control
