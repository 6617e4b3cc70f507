// The whole of a wide search, as the overlap checker does it job by job.
#pragma once

#include <memory>

#include "fsw/base/math.hpp"

#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/overlap/wide_search.hpp"

namespace ilp::test {

inline OverlapResult search_widely(GrayView a, GrayView b, double min_overlap, CoarseCandidates* peaks = nullptr) {
  static const auto workspace = std::make_unique<OverlapWorkspace>();
  static const auto keyframe = std::make_unique<OverlapTemplate>();
  static const auto input = std::make_unique<WideInput>();
  static const auto output = std::make_unique<WideOutput>();
  static const auto canvas = std::make_unique<WideWorkspace>();
  OverlapResult result;
  if (!prepare_overlap(a, *keyframe, *workspace).ok() || !workspace->b.build(b, coarse_max_side).ok()) return result;
  const int level = wide_search_level(keyframe->pyramid);
  WidePlan plan;
  if (!prepare_wide_search(keyframe->pyramid.level(level), workspace->b.level(level), min_overlap, *input, plan).ok()) {
    return result;
  }
  CoarseCandidates candidates;
  for (std::int32_t job = 0; job < plan.jobs(); ++job) {
    fill_wide_job(plan, job, *input);
    for (std::size_t k = 0; k < wide_job_poses; ++k) search_wide_pose(*input, k, *canvas, output->best[k]);
    collect_wide_peaks(plan, job, *input, *output, candidates);
  }
  if (peaks != nullptr) *peaks = candidates;
  OverlapParams params{.min_overlap = min_overlap, .max_rotation_rad = pi, .max_scale = coarse_max_scale};
  const Status judged = measure_overlap_of(*keyframe, b, candidates, params, *workspace, result);
  if (!judged.ok()) result.verdict = OverlapVerdict::overlap_unknown;
  return result;
}

}  // namespace ilp::test
