#include "fsw/vision/twoview/robust/essential_problem.hpp"

#include <limits>

#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/robust/local_optimisation.hpp"
#include "fsw/vision/twoview/robust/model_score.hpp"
#include "fsw/vision/twoview/solvers/decompose_essential.hpp"

namespace ilp {

double select_inliers(const NormalisedPairs& pairs, const RigidTransform& b_from_a, double threshold_px,
                      PairIndices& selected) {
  const Mat3 essential = essential_from_pose(b_from_a);
  const double min_angle = threshold_angle(pairs.scale, threshold_px);
  return select_matches(pairs, threshold_px, selected, [&](const NormalisedPair& pair) {
    const double squared = sampson_squared(essential, pair, pairs.scale);
    if (!(squared < threshold_px * threshold_px)) return squared;
    const bool in_front = meets_in_front(b_from_a, pair.ray_a(), pair.ray_b(), min_angle);
    return in_front ? squared : std::numeric_limits<double>::infinity();
  });
}

std::size_t EssentialProblem::solve(const std::uint16_t* sample, Model* models) {
  Vec3 a[sample_size];
  Vec3 b[sample_size];
  for (std::size_t i = 0; i < sample_size; ++i) {
    a[i] = pairs.exact[sample[i]].ray_a();
    b[i] = pairs.exact[sample[i]].ray_b();
  }
  Mat3 essentials[max_five_point_solutions];
  const std::size_t essential_count = five_point(a, b, essentials);
  const double min_angle = threshold_angle(pairs.scale, threshold_px);
  std::size_t count = 0;
  for (std::size_t k = 0; k < essential_count; ++k) {
    RigidTransform poses[4];
    if (!decompose_essential(essentials[k], poses)) continue;
    for (const RigidTransform& pose : poses) {
      bool visible = true;
      for (std::size_t i = 0; i < sample_size && visible; ++i) visible = meets_in_front(pose, a[i], b[i], min_angle);
      if (visible) models[count++] = pose;
    }
  }
  return count;
}

bool EssentialProblem::score(const Model& model, const CostBound& bound, RansacScore& score) const {
  // Cheirality only adds cost, so the cheaper test rejects most wrong models first.
  return score_epipolar(pairs, essential_from_pose(model), threshold_px, bound, score) &&
         score_pose(pairs, model, threshold_px, bound, score);
}

bool EssentialProblem::improve(Model& model) {
  select_inliers(pairs, model, local_widening * threshold_px, scratch);
  return refine_relative_pose(pairs, {scratch.data(), scratch.size()}, local_refinement(threshold_px), model);
}

}  // namespace ilp
