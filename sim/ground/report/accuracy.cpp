#include "sim/ground/report/accuracy.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <system_error>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

void measure_track(const std::vector<Vec3>& centres, StripAccuracy& accuracy) {
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (i > 0) accuracy.length += (centres[i] - centres[i - 1]).norm();
    for (std::size_t k = 0; k < i; ++k) accuracy.extent = std::max(accuracy.extent, (centres[i] - centres[k]).norm());
  }
}

std::vector<double> lengths(const std::vector<Vec3>& errors) {
  std::vector<double> all;
  for (const Vec3& error : errors) all.push_back(error.norm());
  return all;
}

bool is_depth(double z) {
  return z > 0 && std::isfinite(z);
}

std::optional<DepthAccuracy> compare_depth(const host::Raster<float>& inverse_depth, const host::Raster<float>& truth,
                                           double scale) {
  if (!truth.same_size(inverse_depth.width, inverse_depth.height) || truth.empty()) {
    return std::nullopt;
  }
  std::vector<double> all, ratios;
  for (std::size_t i = 0; i < truth.samples.size(); ++i) {
    if (!is_depth(truth.samples[i])) continue;
    all.push_back(truth.samples[i]);
    const float inverse = inverse_depth.samples[i];
    if (inverse > 0) ratios.push_back(static_cast<double>(truth.samples[i]) * inverse);
  }
  if (ratios.empty()) return std::nullopt;
  DepthAccuracy accuracy;
  accuracy.pixels = ratios.size();
  accuracy.flying_height = host::median(std::move(all));
  const double own_scale = host::median(std::move(ratios));
  std::vector<double> signed_errors, errors, own_errors;
  for (std::size_t i = 0; i < truth.samples.size(); ++i) {
    const float inverse = inverse_depth.samples[i];
    const double z = truth.samples[i];
    if (!is_depth(z) || !(inverse > 0)) continue;
    signed_errors.push_back(scale / inverse - z);
    errors.push_back(std::fabs(signed_errors.back()));
    own_errors.push_back(std::fabs(own_scale / inverse - z));
  }
  const double percent = 100 / accuracy.flying_height;
  accuracy.median_abs = host::median(std::move(errors));
  accuracy.median_abs_percent = accuracy.median_abs * percent;
  accuracy.own_scale_percent = host::median(std::move(own_errors)) * percent;
  accuracy.bias_percent = host::median(std::move(signed_errors)) * percent;
  return accuracy;
}

}  // namespace

std::string foreign_reference(std::size_t poses, double rotation_deg, double position_percent) {
  // Many times what the worst flight has against its own reference.
  constexpr double most_rotation_deg = 10, most_position_percent = 10;
  const bool fits = !(rotation_deg >= most_rotation_deg || position_percent >= most_position_percent);
  if (poses < fewest_poses || fits) return "";
  return "after the best alignment, " + host::counted(poses, "pose") + " and the reference differ by " +
         host::brief(rotation_deg) + " degrees and " + host::brief(position_percent) +
         " % of the distance flown (means): is the reference of this flight?";
}

PosePairs pose_pairs(const intake::Flight& flight, const intake::Strip& strip, const Reference& reference) {
  PosePairs pairs;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    const ReferencePose* truth = reference.pose(keyframe.name);
    if (truth == nullptr) continue;
    const Pose pose = pose_of(*keyframe.pose);
    pairs.keyframes.push_back(id);
    pairs.track.add(Vec3(pose.centre[0], pose.centre[1], pose.centre[2]),
                    rotation_from_quaternion(pose.q_cam_from_world));
    pairs.reference.add(truth->centre, truth->cam_from_world);
  }
  return pairs;
}

std::optional<StripAccuracy> measure_accuracy(const intake::Flight& flight, const intake::Strip& strip,
                                              const Reference& reference) {
  const PosePairs pairs = pose_pairs(flight, strip, reference);
  const auto errors = host::track_errors(pairs.track, pairs.reference);
  if (!errors) return std::nullopt;

  StripAccuracy accuracy;
  accuracy.reference_from_strip = errors->reference_from_track;
  accuracy.poses = pairs.keyframes.size();
  measure_track(pairs.reference.centres, accuracy);
  const std::vector<double> position = lengths(errors->position);
  accuracy.position = host::summarise(position);
  const auto fixed =
      host::align_positions(pairs.track.centres, pairs.reference.centres, errors->reference_axes_from_track);
  if (fixed) {
    accuracy.position_with_attitude =
        host::summarise(lengths(host::position_errors(*fixed, pairs.track, pairs.reference)));
  }
  std::vector<double> depths;
  for (std::size_t i = 0; i < pairs.keyframes.size(); ++i) {
    KeyframeAccuracy& k = accuracy.keyframes[pairs.keyframes[i]];
    k.position = position[i];
    k.rotation_rad = errors->rotation_rad[i];
    const intake::Keyframe& keyframe = flight.keyframes.at(pairs.keyframes[i]);
    if (!keyframe.has_depth()) continue;
    k.depth = compare_depth(intake::decode_products(keyframe).rasters.inverse_depth, reference.depth(keyframe.name),
                            errors->reference_from_track.scale);
    if (k.depth) depths.push_back(k.depth->median_abs_percent);
  }
  accuracy.rotation_rad = host::summarise(errors->rotation_rad);
  if (!depths.empty()) accuracy.depth_percent = host::summarise(depths);
  return accuracy;
}

std::optional<MapAccuracy> measure_on_map(const intake::Flight& flight, const intake::Strip& strip,
                                          const Reference& reference) {
  const PosePairs pairs = pose_pairs(flight, strip, reference);
  if (!strip.map || strip.control || pairs.keyframes.empty()) return std::nullopt;
  std::vector<double> position, horizontal, squares;
  for (std::size_t i = 0; i < pairs.keyframes.size(); ++i) {
    const Vec3 error = pairs.track.centres[i] - pairs.reference.centres[i];
    position.push_back(error.norm());
    horizontal.push_back(error.head<2>().norm());
    const PoseRecord& pose = *flight.keyframes.at(pairs.keyframes[i]).pose;
    Mat3 covariance;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        const int low = 3 + std::min(row, column), high = 3 + std::max(row, column);
        covariance(row, column) = pose.covariance[high * (high + 1) / 2 + low];
      }
    }
    const double square = error.dot(covariance.inverse() * error) / 3;
    if (std::isfinite(square)) squares.push_back(square);
  }
  MapAccuracy accuracy{host::summarise(position), host::summarise(horizontal)};
  if (!squares.empty()) accuracy.nes = host::summarise(squares).mean;
  return accuracy;
}

ReferenceFiles::ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder)
    : depth_folder_(std::move(depth_folder)) {
  for (const host::ReferenceCamera& camera : host::read_reference_cameras(poses)) {
    const bool added =
        poses_.emplace(host::image_key(camera.name), ReferencePose{camera.cam_from_world, camera.centre}).second;
    if (!added) {
      throw std::runtime_error("reference poses " + poses.string() + ": '" + camera.name +
                               "' and another name differ only in their extension");
    }
  }
}

const ReferencePose* ReferenceFiles::pose(const std::string& name) const {
  const auto found = poses_.find(host::image_key(name));
  return found == poses_.end() ? nullptr : &found->second;
}

host::Raster<float> ReferenceFiles::depth(const std::string& name) const {
  if (depth_folder_.empty()) return {};
  for (const std::string& base : {host::stem(name), name}) {
    const std::filesystem::path path = depth_folder_ / (base + ".pfm");
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    return host::read_pfm(path);
  }
  return {};
}

}  // namespace ilp::report
