#include "sim/ground/report/accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"

namespace ilp::ground {
namespace {

struct Pairs {
  std::vector<std::int64_t> ids;
  std::vector<Vec3> estimates, references;
  std::vector<Mat3> estimate_attitudes, reference_attitudes;
};

Pairs collect(const Flight& flight, const Strip& strip, const Reference& reference) {
  Pairs pairs;
  for (const std::int64_t id : strip.keyframes) {
    const Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    const ReferencePose* truth = reference.pose(keyframe.name);
    if (truth == nullptr) continue;
    const Pose pose = pose_of(*keyframe.pose);
    pairs.ids.push_back(id);
    pairs.estimates.emplace_back(pose.centre[0], pose.centre[1], pose.centre[2]);
    pairs.references.push_back(truth->centre);
    pairs.estimate_attitudes.push_back(rotation_from_quaternion(pose.q_cam_from_world));
    pairs.reference_attitudes.push_back(truth->cam_from_world);
  }
  return pairs;
}

void measure_track(const std::vector<Vec3>& centres, StripAccuracy& accuracy) {
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (i > 0) accuracy.length += (centres[i] - centres[i - 1]).norm();
    for (std::size_t k = 0; k < i; ++k) accuracy.extent = std::max(accuracy.extent, (centres[i] - centres[k]).norm());
  }
}

std::vector<double> residuals(const Similarity3& alignment, const Pairs& pairs) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.ids.size(); ++i) {
    errors.push_back((alignment * pairs.estimates[i] - pairs.references[i]).norm());
  }
  return errors;
}

bool is_depth(double z) {
  return z > 0 && std::isfinite(z);
}

std::optional<DepthAccuracy> compare_depth(const Raster<float>& inverse_depth, const Raster<float>& truth,
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
  accuracy.flying_height = median(std::move(all));
  const double own_scale = median(std::move(ratios));
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
  accuracy.median_abs = median(std::move(errors));
  accuracy.median_abs_percent = accuracy.median_abs * percent;
  accuracy.own_scale_percent = median(std::move(own_errors)) * percent;
  accuracy.bias_percent = median(std::move(signed_errors)) * percent;
  return accuracy;
}

}  // namespace

std::optional<StripAccuracy> measure_accuracy(const Flight& flight, const Strip& strip, const Reference& reference) {
  const Pairs pairs = collect(flight, strip, reference);
  const auto alignment = align_positions(pairs.estimates, pairs.references);
  if (!alignment) return std::nullopt;

  StripAccuracy accuracy;
  accuracy.reference_from_strip = *alignment;
  accuracy.poses = pairs.ids.size();
  measure_track(pairs.references, accuracy);
  const std::vector<double> position = residuals(*alignment, pairs);
  accuracy.position = summarise(position);

  // cam_from_reference * W = cam_from_estimate, so W takes strip axes to reference axes.
  const Mat3 reference_from_strip = align_attitudes(pairs.estimate_attitudes, pairs.reference_attitudes);
  if (const auto fixed = align_positions(pairs.estimates, pairs.references, reference_from_strip)) {
    accuracy.position_with_attitude = summarise(residuals(*fixed, pairs));
  }
  std::vector<double> rotations, depths;
  for (std::size_t i = 0; i < pairs.ids.size(); ++i) {
    KeyframeAccuracy& k = accuracy.keyframes[pairs.ids[i]];
    k.position = position[i];
    const Mat3 turn = pairs.reference_attitudes[i] * reference_from_strip * pairs.estimate_attitudes[i].transpose();
    k.rotation_rad = rotation_angle(turn);
    rotations.push_back(k.rotation_rad);
    const Keyframe& keyframe = flight.keyframes.at(pairs.ids[i]);
    if (!keyframe.has_depth()) continue;
    k.depth = compare_depth(decode_products(keyframe).rasters.inverse_depth, reference.depth(keyframe.name),
                            alignment->scale);
    if (k.depth) depths.push_back(k.depth->median_abs_percent);
  }
  accuracy.rotation_rad = summarise(rotations);
  if (!depths.empty()) accuracy.depth_percent = summarise(depths);
  return accuracy;
}

}  // namespace ilp::ground
