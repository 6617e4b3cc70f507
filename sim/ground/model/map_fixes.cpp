#include "sim/ground/model/map_fixes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "fsw/shared/measured_keyframe.hpp"
#include "sim/ground/model/common_errors.hpp"
#include "sim/ground/model/moving.hpp"
#include "sim/ground/model/normal_equations.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

/// Medians of the sums of three and of six squares of errors whose sigma is 1 (chi-squared).
constexpr double median_of_three = 2.366, median_of_six = 5.348;
/// Sightings are not taken for more exact.
constexpr double least_sighting_px = 0.02;

bool is_on(const intake::MapPlace& map, const std::optional<FixRecord>& fix) {
  return fix && fix->state == FixState::accepted && fix->map_id == map.map_id && fix->body == map.body &&
         fix->map_longitude_deg == map.longitude_deg && fix->map_latitude_deg == map.latitude_deg &&
         fix_measurement(*fix, map_origin_of(*fix)).ground_sigma_m[0] > 0;
}

/// None where the covariance of the record is none.
std::optional<ViewFix> view_fix(std::uint32_t view, const FixRecord& fix) {
  Mat6 covariance;
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++k)
      covariance(row, column) = covariance(column, row) = fix.covariance[k];
  }
  // Radians and metres: the decomposition sees numbers of one size.
  const Vec6 sigmas = covariance.diagonal().cwiseSqrt();
  if (!(sigmas.minCoeff() > 0)) return std::nullopt;
  const Vec6 inverse_sigmas = sigmas.cwiseInverse();
  const Eigen::LLT<Mat6> root(inverse_sigmas.asDiagonal() * covariance * inverse_sigmas.asDiagonal());
  if (root.info() != Eigen::Success) return std::nullopt;
  ViewFix out{view, rotation_from_quaternion(fix.q_cam_from_map), vector_of(fix.centre_m), Mat6::Zero()};
  const Mat6 scaled = inverse_sigmas.asDiagonal();
  out.sigmas_from_error = root.matrixL().solve(scaled);
  if (!out.sigmas_from_error.allFinite()) return std::nullopt;
  return out;
}

std::vector<ViewFix> fixes_on(const Scene& scene, const intake::MapPlace& map, const Model& model) {
  std::vector<ViewFix> fixes;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    if (!model.views[v].in || !is_on(map, scene.views[v].keyframe->fix)) continue;
    if (const auto fix = view_fix(v, *scene.views[v].keyframe->fix)) fixes.push_back(*fix);
  }
  return fixes;
}

/// The fixes of the model, with the poses that it has: what a strip's place is estimated from on board.
navigation::MeasuredKeyframes measured_by(const Scene& scene, const Model& model, const std::vector<ViewFix>& fixes) {
  std::map<std::int64_t, double> units;
  navigation::MeasuredKeyframes measured;
  for (const ViewFix& fix : fixes) {
    const View& view = scene.views[fix.view];
    const RigidTransform& pose = model.views[fix.view].camera_from_model;
    if (!units.contains(view.strip_id)) {
      const auto similarity = model_from_strip(scene, model, view.strip_id);
      units[view.strip_id] = similarity ? similarity->scale : 0;
    }
    navigation::MeasuredKeyframe one;
    one.keyframe_id = view.keyframe_id;
    const Vec3 centre = centre_of(pose);
    std::copy_n(centre.data(), 3, one.centre);
    quaternion_from_rotation(pose.rotation, one.q_cam_from_strip);
    one.fix = fix_measurement(*view.keyframe->fix, map_origin_of(*view.keyframe->fix));
    one.fix.depth *= units[view.strip_id];
    one.fix.depth_sigma *= units[view.strip_id];
    navigation::add_thinned(one, measured);
  }
  return measured;
}

bool is_whole(const navigation::StripFrame& frame) {
  return frame.fixed_sigma_m[0] > 0 && frame.scale_sigma > 0 && frame.tilt_sigma_rad > 0 && frame.heading_sigma_rad > 0;
}

}  // namespace

std::optional<intake::MapPlace> map_of(const intake::Flight& flight) {
  struct Accepted {
    intake::MapPlace map;
    std::size_t fixes = 0;
  };
  // A record may say anything of its map: fixes are on one map if they say the same.
  std::map<std::tuple<std::int64_t, Body, double, double>, Accepted> maps;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!keyframe.fix || !keyframe.posed()) continue;
    const FixRecord& fix = *keyframe.fix;
    const intake::MapPlace map{fix.map_id, fix.body, fix.map_longitude_deg, fix.map_latitude_deg, fix.map_sigma_m, 0};
    if (!is_on(map, fix)) continue;
    ++maps.try_emplace({map.map_id, map.body, map.longitude_deg, map.latitude_deg}, Accepted{map}).first->second.fixes;
  }
  const auto most = std::max_element(maps.begin(), maps.end(),
                                     [](const auto& a, const auto& b) { return a.second.fixes < b.second.fixes; });
  if (most == maps.end() || most->second.fixes < least_fixes) return std::nullopt;
  return most->second.map;
}

bool place_on_map(const Scene& scene, const intake::MapPlace& map, Model& model) {
  std::vector<ViewFix> fixes = fixes_on(scene, map, model);
  if (fixes.size() < least_fixes) return false;
  const navigation::StripFrame frame = navigation::estimate_strip_frame(measured_by(scene, model, fixes));
  if (!is_whole(frame)) return false;
  Similarity by;
  by.scale = frame.metres_per_unit;
  by.rotation = frame.level_from_strip;
  by.translation = frame.fixed_place_m - by.scale * (by.rotation * frame.fixed_ground);
  move(by, model);
  model.fixes = std::move(fixes);
  return true;
}

Model united(const Scene& scene, std::vector<Model> parts) {
  for (Model& part : parts) grow(scene, part);
  Model all = std::move(parts.front());
  all.by_sub_maps = false;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const Model& part = parts[i];
    for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
      for (std::size_t s = 0; s < scene.tracks[t].seen.size(); ++s) {
        if (part.views[scene.tracks[t].seen[s].view].in) all.refuse(t, s, part.refuses(t, s));
      }
      if (!all.points[t].placed) all.points[t] = part.points[t];
    }
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      if (part.views[v].in) all.views[v] = part.views[v];
    }
    all.fixes.insert(all.fixes.end(), part.fixes.begin(), part.fixes.end());
  }
  return all;
}

namespace {

std::vector<double> errors_in(const ModelProblem& problem, const FixWeights& weights) {
  std::vector<double> errors;
  for (const AdjustedPrior& prior : problem.priors) errors.push_back(error_of(problem, prior) / weights.image_px);
  return errors;
}

/// As large as the median of so many normalised errors may be where they are as stated, by about three deviations.
double by_chance(std::size_t count) {
  return 1 + 1.5 / std::sqrt(static_cast<double>(count));
}

/// By how much the errors of fixes exceed the stated ones by what places of neighbouring fixes of a strip differ; 1 or
/// more.
double factor_by_neighbours(const Scene& scene, const Model& model) {
  const auto error = [&](const ViewFix& fix) {
    return Vec3(centre_of(model.views[fix.view].camera_from_model) - fix.centre);
  };
  const auto covariance = [](const ViewFix& fix) {
    const Mat6 all = (fix.sigmas_from_error.transpose() * fix.sigmas_from_error).inverse();
    return Mat3(all.bottomRightCorner<3, 3>());
  };
  std::vector<double> squares;
  for (std::size_t i = 1; i < model.fixes.size(); ++i) {
    const ViewFix &a = model.fixes[i - 1], &b = model.fixes[i];
    if (scene.views[a.view].strip_id != scene.views[b.view].strip_id) continue;
    const Vec3 difference = error(b) - error(a);
    squares.push_back(difference.dot((covariance(a) + covariance(b)).inverse() * difference));
  }
  if (squares.empty()) return 1;
  const double chance = by_chance(squares.size());
  const double factor = std::sqrt(host::median(std::move(squares)) / median_of_three);
  return factor > chance ? factor : 1;
}

}  // namespace

std::vector<double> fix_errors(const Scene& scene, const Model& model) {
  return errors_in(problem_of(scene, model), model.fix_weights);
}

bool weigh_fixes(const Scene& scene, bool adjusted, Model& model) {
  const ModelProblem problem = problem_of(scene, model);
  FixWeights& weights = model.fix_weights;
  const double before = weights.error_factor;
  bool changed = false;
  const double median = before * host::median(errors_in(problem, weights));  // in estimated errors
  if (adjusted) {
    weights.error_factor = factor_by_neighbours(scene, model);
    const double left = median / weights.error_factor / std::sqrt(median_of_six);
    changed = left > by_chance(model.fixes.size());
    if (changed) weights.image_factor *= left;
    constexpr double hardly = 1.1;
    changed = changed || weights.error_factor > hardly * before || before > hardly * weights.error_factor;
  }
  weights.image_px =
      weights.image_factor * std::max(least_sighting_px, std::sqrt(variance_of_sightings(problem).value_or(0) *
                                                                   common_errors_of(problem, last_robust_px).factor()));
  weights.loss = std::max(last_fix_loss, 2 * median / weights.error_factor);
  return changed;
}

}  // namespace ilp::model
