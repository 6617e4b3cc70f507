// The wide search for the overlap of one pair, job by job, on whatever does the jobs (docs/compute.md).
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/overlap/wide_search.hpp"
#include "hal/compute/compute.hpp"

namespace ilp {

/// The jobs of a wide search. `workspace` is the processor's.
[[nodiscard]] ComputeForm wide_search_form(WideWorkspace& workspace);

struct WideJob {
  WideInput input{};
  WideOutput output{};
};

/// Carries nothing from one pair to the next, and nothing of it is on record: after a restart the pair begins again.
class WideOverlap {
 public:
  /// Whether a search for this pair has begun.
  [[nodiscard]] bool at_work(std::int64_t frame_id, std::int64_t keyframe_id) const {
    return frame_id == frame_id_ && keyframe_id == keyframe_id_;
  }
  /// Takes what it needs out of the images. `before` is the answer without the search. Errors as of
  /// prepare_wide_search().
  Status begin(std::int64_t frame_id, std::int64_t keyframe_id, const OverlapTemplate& keyframe, GrayView image,
               const OverlapResult& before, double min_overlap, OverlapWorkspace& workspace);
  /// One step. `done`: no job is left.
  Result<ComputeProgress> go_on(Compute& compute);
  /// The answer: that of the search if it is one, otherwise the one before it. The search is over.
  Status finish(const OverlapTemplate& keyframe, GrayView image, OverlapWorkspace& workspace, OverlapResult& result);
  void drop(Compute& compute);

 private:
  std::int64_t frame_id_ = 0, keyframe_id_ = 0;
  OverlapResult before_;
  WidePlan plan_;
  std::int32_t job_ = 0;
  bool submitted_ = false;
  CoarseCandidates candidates_;
  WideJob memory_;
};

}  // namespace ilp
