#include "sim/tools/score/depth_score.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/stereo/depth/pose_error.hpp"
#include "sim/ground/map/merge.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::score {
namespace {

Vec3 mean(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& point : points) sum += point / static_cast<double>(points.size());
  return sum;
}

bool is_depth(float z) {
  return z > 0 && std::isfinite(z);
}

void append_to(std::vector<float>& to, const std::vector<float>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Depth in strip units times this is the true depth, for the median pixel.
double own_scale(const std::vector<float>& inverse, const std::vector<float>& truth) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    if (inverse[i] > 0 && is_depth(truth[i])) ratios.push_back(static_cast<double>(truth[i]) * inverse[i]);
  }
  return host::median(std::move(ratios));
}

struct StepError {
  RigidTransform partner_from_this;
  StepCovariance covariance;
  double by_lens = 0;  ///< share of the depth
};

StepError step_error(const intake::Keyframe& keyframe, std::span<const intake::Keyframe* const> to_partner) {
  StepError sum;
  const PoseRecord* before = &*keyframe.pose;
  for (const intake::Keyframe* next : to_partner) {
    const RigidTransform step =
        compose(cam_from_world(pose_of(*next->pose)), inverse(cam_from_world(pose_of(*before))));
    StepCovariance covariance;
    for (int i = 0; i < StepCovariance::elements; ++i) covariance.lower[i] = next->pose->step_covariance[i];
    const bool first = before == &*keyframe.pose;
    sum.covariance = first ? covariance : joined_steps(sum.partner_from_this, sum.covariance, step, covariance);
    sum.partner_from_this = first ? step : compose(step, sum.partner_from_this);
    sum.by_lens = next->pose->lens_depth_sigma;
    before = &*next->pose;
  }
  return sum;
}

double flying_height_of(const world::TrueFrame& truth) {
  std::vector<double> depths;
  for (const float z : truth.depth) {
    if (is_depth(z)) depths.push_back(z);
  }
  return host::median(std::move(depths));
}

}  // namespace

ErrorPercent error_percent(const std::vector<float>& signed_percent) {
  ErrorPercent summary;
  summary.count = signed_percent.size();
  if (signed_percent.empty()) return summary;
  std::vector<double> values(signed_percent.begin(), signed_percent.end());
  summary.bias = host::median(values);
  for (double& value : values) value = std::fabs(value);
  summary.median = host::median(values);
  summary.p95 = host::percentile(std::move(values), 0.95);
  return summary;
}

SigmaShares sigma_shares(const std::vector<float>& errors_in_sigmas) {
  SigmaShares shares;
  shares.count = errors_in_sigmas.size();
  if (errors_in_sigmas.empty()) return shares;
  std::vector<double> squares;
  std::size_t one = 0, two = 0;
  double sum = 0;
  for (const float error : errors_in_sigmas) {
    const double square = static_cast<double>(error) * error;
    squares.push_back(square);
    sum += square;
    one += square <= 1 ? 1U : 0U;
    two += square <= 4 ? 1U : 0U;
  }
  const auto n = static_cast<double>(shares.count);
  constexpr double median_of_chi_square = 0.454936;  // one degree of freedom
  shares.within_1 = static_cast<double>(one) / n;
  shares.within_2 = static_cast<double>(two) / n;
  shares.squared = sum / n;
  shares.squared_robust = host::median(std::move(squares)) / median_of_chi_square;
  return shares;
}

std::optional<AlignedStrip> align_strip(const intake::Flight& flight, const intake::Strip& strip,
                                        const report::Reference& reference, double flying_height) {
  const report::PosePairs pairs = report::pose_pairs(flight, strip, reference);
  const auto similarity = host::align_cameras(pairs.track.centres, pairs.track.cam_from_world, pairs.reference.centres,
                                              pairs.reference.cam_from_world, flying_height);
  if (!similarity || !(similarity->scale > 0)) return std::nullopt;
  AlignedStrip aligned{strip.id, pairs.keyframes, *similarity, {}};
  const bool metric = std::all_of(pairs.keyframes.begin(), pairs.keyframes.end(), [&](std::int64_t id) {
    return flight.keyframes.at(id).pose->scale_source != ScaleSource::first_baseline;
  });
  if (metric) {
    host::Similarity3 rigid{1, similarity->rotation, Vec3::Zero()};
    rigid.translation = mean(pairs.reference.centres) - rigid * mean(pairs.track.centres);
    aligned.true_from_metric_strip = rigid;
  }
  return aligned;
}

/// The sigma of a keyframe whose product has none by blocks.
std::optional<double> estimated_sigma(const intake::Keyframe& keyframe) {
  if (!keyframe.depth) return std::nullopt;
  const DepthRecord& record = *keyframe.depth;
  if (!(record.median_sigma_px > 0) || !(record.disparity_per_inverse_depth_px > 0)) return std::nullopt;
  const double matching = record.median_sigma_px / record.disparity_per_inverse_depth_px;
  return std::sqrt(matching * matching + record.step * record.step / 12);
}

void DepthErrors::append(const DepthErrors& other) {
  append_to(strip_scale, other.strip_scale);
  append_to(metric_scale, other.metric_scale);
  append_to(own_scale, other.own_scale);
  append_to(height, other.height);
  append_to(in_sigmas, other.in_sigmas);
  append_to(own_in_sigmas, other.own_in_sigmas);
  append_to(in_sigmas_with_poses, other.in_sigmas_with_poses);
}

DepthErrors depth_errors(const intake::Keyframe& keyframe, std::span<const intake::Keyframe* const> to_partner,
                         const world::TrueFrame& truth, const AlignedStrip& strip, map::PixelRays& rays) {
  DepthErrors errors;
  errors.flying_height = flying_height_of(truth);
  if (!map::has_surface(keyframe) || !keyframe.inverse_depth.same_size(truth.columns, truth.rows)) return errors;
  const std::vector<float>& inverse = keyframe.inverse_depth.samples;
  const double scale = strip.true_from_strip.scale, own = own_scale(inverse, truth.depth);
  const double percent = 100 / errors.flying_height;
  const std::optional<double> whole = estimated_sigma(keyframe);
  const Mat3 world_from_cam = rotation_from_quaternion(keyframe.pose->q_cam_from_world).transpose();
  const Vec3 centre(keyframe.pose->centre[0], keyframe.pose->centre[1], keyframe.pose->centre[2]);
  const StepError step = step_error(keyframe, to_partner);
  const std::vector<map::Ray>& ray = rays.of(keyframe.camera).samples;
  const auto add = [](std::vector<float>& to, double value) { to.push_back(static_cast<float>(value)); };
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    const double d = inverse[i], z = truth.depth[i];
    if (!(d > 0) || !is_depth(truth.depth[i])) continue;
    add(errors.strip_scale, percent * (scale / d - z));
    add(errors.own_scale, percent * (own / d - z));
    if (strip.true_from_metric_strip) add(errors.metric_scale, percent * (1 / d - z));
    const Vec3 point = strip.true_from_strip * (centre + world_from_cam * Vec3(ray[i].x / d, ray[i].y / d, 1 / d));
    add(errors.height, percent * (point.z() - truth.ground[i].z()));
    const auto width = static_cast<std::size_t>(keyframe.inverse_depth.width);
    const double by_block = intake::inverse_depth_sigma(keyframe, static_cast<std::int32_t>(i % width),
                                                        static_cast<std::int32_t>(i / width));
    const double sigma = by_block > 0 ? by_block : whole.value_or(0);
    if (sigma > 0) {
      add(errors.in_sigmas, (d - scale / z) / sigma);
      if (step.covariance.known()) {
        const double of_poses =
            d * depth_error_of_poses(step.partner_from_this, step.covariance, {ray[i].x, ray[i].y}, 1 / d);
        add(errors.in_sigmas_with_poses, (d - scale / z) / std::hypot(sigma, of_poses, d * step.by_lens));
      }
      add(errors.own_in_sigmas, (d - own / z) / sigma);
    }
  }
  return errors;
}

DepthScore depth_score(const DepthErrors& errors) {
  DepthScore score;
  score.flying_height = errors.flying_height;
  score.strip_scale = error_percent(errors.strip_scale);
  score.own_scale = error_percent(errors.own_scale);
  score.height = error_percent(errors.height);
  if (!errors.metric_scale.empty()) score.metric_scale = error_percent(errors.metric_scale);
  score.sigma = sigma_shares(errors.in_sigmas);
  score.own_sigma = sigma_shares(errors.own_in_sigmas);
  score.sigma_with_poses = sigma_shares(errors.in_sigmas_with_poses);
  return score;
}

}  // namespace ilp::score
