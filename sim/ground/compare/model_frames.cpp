#include "sim/ground/compare/model_frames.hpp"

#include <cpl_conv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/files.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/host/statistics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::compare {
namespace {
namespace fs = std::filesystem;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t fewest_poses = 3;

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error(what);
}

bool is_local(const OGRSpatialReference* system) {
  return system == nullptr || system->IsLocal() != 0;
}

std::string name_of(const OGRSpatialReference& system) {
  const char* const name = system.GetName();
  return name != nullptr ? name : "without a name";
}

std::string wkt_of(const OGRSpatialReference* system) {
  if (system == nullptr) return {};
  const char* const options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", nullptr};
  char* text = nullptr;
  if (system->exportToWkt(&text, options) != OGRERR_NONE)
    throw host::gdal_error("a coordinate system cannot be written");
  std::string wkt = text;
  CPLFree(text);
  return wkt;
}

/// Bodies differ by more than a per cent, figures of one body by less.
void check_body(const HeightModel& map, const HeightModel& other, std::vector<std::string>& remarks) {
  const double ours = map.system()->GetSemiMajor(), theirs = other.system()->GetSemiMajor();
  if (std::fabs(ours - theirs) > 0.01 * ours) {
    refuse(other.path().string() + ": the model is on another body. The equatorial radius of its system (" +
           name_of(*other.system()) + ") is " + host::fixed(theirs / 1e3, 1) + " km, that of the map (" +
           name_of(*map.system()) + ") is " + host::fixed(ours / 1e3, 1) + " km");
  }
  const double our_pole = map.system()->GetSemiMinor(), their_pole = other.system()->GetSemiMinor();
  if (std::fabs(ours - theirs) > 1 || std::fabs(our_pole - their_pole) > 1) {
    remarks.push_back(
        "The two coordinate systems have different figures of the body. Heights are compared as they are stated; the "
        "vertical shift contains the difference of the figures");
  }
}

struct NamedPose {
  Vec3 centre = Vec3::Zero();
  Mat3 cam_from_map = Mat3::Identity();
};

double number_of(const OGRFeature& feature, const char* field) {
  const int at = feature.GetFieldIndex(field);
  if (at < 0 || feature.IsFieldSetAndNotNull(at) == 0) return no_number;
  const char* const text = feature.GetFieldAsString(at);
  return *text != '\0' ? CPLAtof(text) : no_number;
}

/// The posed keyframes of one strip, in the axes of its map: from the table that ilp-ground writes beside it.
std::map<std::string, NamedPose> poses_of(const fs::path& table, double strip) {
  const host::Dataset file(GDALDataset::Open(table.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY));
  if (!file || file->GetLayerCount() != 1) throw host::gdal_error(table.string() + ": cannot be read");
  std::map<std::string, NamedPose> poses;
  OGRLayer& layer = *file->GetLayer(0);
  while (const OGRFeatureUniquePtr feature{layer.GetNextFeature()}) {
    if (!std::isnan(strip) && number_of(*feature, "strip") != strip) continue;
    if (std::isnan(strip)) strip = number_of(*feature, "strip");
    const Vec3 centre(number_of(*feature, "x"), number_of(*feature, "y"), number_of(*feature, "z"));
    const double q[4] = {number_of(*feature, "q_w"), number_of(*feature, "q_x"), number_of(*feature, "q_y"),
                         number_of(*feature, "q_z")};
    const int name = feature->GetFieldIndex("name");
    if (name < 0 || !centre.allFinite() || !std::isfinite(q[0] + q[1] + q[2] + q[3])) continue;
    poses[host::image_key(feature->GetFieldAsString(name))] = {centre, rotation_from_quaternion(q)};
  }
  return poses;
}

/// height-strip-2.tif is of strip 2; height.tif is of the first strip in the table.
double strip_of(const fs::path& map) {
  const std::string name = map.stem().string();
  const std::string mark = "-strip-";
  const std::size_t at = name.rfind(mark);
  return at == std::string::npos ? no_number : CPLAtof(name.c_str() + at + mark.size());
}

/// Coordinates of pixel centres instead of corners.
GeoTransform pixel_from_other(const HeightModel& other) {
  GeoTransform forward = other.transform(), inverse{};
  if (GDALInvGeoTransform(forward.data(), inverse.data()) == 0) refuse(other.path().string() + ": pixels of no size");
  inverse[0] -= 0.5;
  inverse[3] -= 0.5;
  return inverse;
}

}  // namespace

ModelFrames::ModelFrames(const HeightModel& map, const HeightModel& other, const FrameOptions& options)
    : pixel_from_other_(pixel_from_other(other)), middle_px_(0.5 * other.columns()) {
  if (!options.poses.empty()) {
    join_by_poses(map, other, options.poses);
  } else if (options.same_axes) {
    system_ = wkt_of(map.system());
    remarks_.emplace_back("Both models are taken to have the same axes, as the command says");
  } else {
    join_systems(map, other);
  }
}

ModelFrames::~ModelFrames() {
  OGRCoordinateTransformation::DestroyCT(static_cast<OGRCoordinateTransformation*>(transformation_));
}

void ModelFrames::join_systems(const HeightModel& map, const HeightModel& other) {
  if (is_local(map.system())) {
    refuse(map.path().string() +
           ": the map is in the axes of its strip and has no place on a body. Place it with ilp-ground --anchor, give "
           "the poses of its images in the coordinates of the other model (--poses), or say --same-axes");
  }
  if (is_local(other.system())) {
    refuse(other.path().string() +
           (other.system() == nullptr ? ": the file states no coordinate system"
                                      : ": the model has local axes, which are not known on a body") +
           ". State it (gdal_edit.py -a_srs), or say --same-axes if its coordinates are those of the map");
  }
  check_body(map, other, remarks_);
  system_ = wkt_of(map.system());
  OGRSpatialReference ours = *map.system(), theirs = *other.system();
  ours.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  theirs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  if (theirs.IsGeographic() != 0) turn_px_ = 360 * pixel_from_other_[1];
  transformation_ = OGRCreateCoordinateTransformation(&ours, &theirs);
  if (transformation_ == nullptr) {
    throw host::gdal_error("coordinates cannot be transformed from " + name_of(ours) + " to " + name_of(theirs));
  }
}

void ModelFrames::join_by_poses(const HeightModel& map, const HeightModel& other, const fs::path& poses) {
  if (!is_local(map.system())) {
    refuse(map.path().string() + ": the map has a place on a body already; --poses is for a map in its strip's axes");
  }
  const fs::path table = map.path().parent_path() / "keyframes.csv";
  std::error_code ignored;
  if (!fs::exists(table, ignored)) refuse(table.string() + ": --poses needs this table of ilp-ground beside the map");
  const std::map<std::string, NamedPose> ours = poses_of(table, strip_of(map.path()));
  host::CameraTrack track, reference;
  for (const host::ReferenceCamera& camera : host::read_reference_cameras(poses)) {
    const auto pose = ours.find(host::image_key(camera.name));
    if (pose == ours.end()) continue;
    track.add(pose->second.centre, pose->second.cam_from_map);
    reference.add(camera.centre, camera.cam_from_world);
  }
  const std::size_t poses_used = track.centres.size();
  const auto by_positions = host::align_positions(track.centres, reference.centres);
  if (poses_used < fewest_poses || !by_positions) {
    refuse(poses.string() + " names " + host::counted(poses_used, "posed keyframe") + " of the map; at least " +
           std::to_string(fewest_poses) + " at different places expected");
  }
  // About the flying height: the distance of the cameras to what lies at the map's heights.
  std::vector<double> reaches;
  const GeoTransform& t = map.transform();
  HeightModel coarse(map.path());
  coarse.reduce(std::max(1, std::max(map.columns(), map.rows()) / 64));
  std::vector<double> heights;
  for (std::int32_t j = 0; j < coarse.reduced_rows(); ++j) {
    for (std::int32_t i = 0; i < coarse.reduced_columns(); ++i) {
      if (std::isfinite(coarse.cell(i, j))) heights.push_back(coarse.cell(i, j));
    }
  }
  const double ground = host::median(heights);
  for (const Vec3& centre : track.centres) reaches.push_back(std::fabs(centre.z() - ground));
  const double cell = std::sqrt(std::fabs(t[1] * t[5] - t[2] * t[4]));
  const double reach = by_positions->scale * std::max(heights.empty() ? 0 : host::median(reaches), cell);
  const auto fitted =
      host::align_cameras(track.centres, track.cam_from_world, reference.centres, reference.cam_from_world, reach);
  common_from_map_ = fitted ? *fitted : *by_positions;
  system_ = wkt_of(other.system());
  remarks_.push_back("The map was laid onto the other model by the poses of " + host::counted(poses_used, "image") +
                     ": one unit of the map is " + host::brief(common_from_map_.scale) + " m");
}

void ModelFrames::to_pixels(std::vector<double>& x, std::vector<double>& y) const {
  if (transformation_ != nullptr) {
    std::vector<int> known(x.size());
    static_cast<OGRCoordinateTransformation*>(transformation_)
        ->Transform(static_cast<int>(x.size()), x.data(), y.data(), nullptr, known.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (known[i] == 0) x[i] = y[i] = no_number;
    }
  }
  const GeoTransform& p = pixel_from_other_;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double column = p[0] + x[i] * p[1] + y[i] * p[2];
    const double row = p[3] + x[i] * p[4] + y[i] * p[5];
    // Longitudes count from 0 to 360 or from -180 to 180: the turn counts that comes nearest to the model.
    if (turn_px_ != 0) column -= turn_px_ * std::round((column - middle_px_) / turn_px_);
    x[i] = column;
    y[i] = row;
  }
}

}  // namespace ilp::compare
