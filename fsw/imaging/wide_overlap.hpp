// Runs the wide search for the overlap of one pair as a sequence of jobs on a Compute (docs/compute.md).
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/overlap/wide_search.hpp"
#include "hal/compute/compute.hpp"

namespace ilp {

/// Describes the jobs of a wide search. `workspace` is used by jobs that the processor carries out.
[[nodiscard]] ComputeForm wide_search_form(WideWorkspace& workspace);

struct WideJob {
  WideInput input{};
  WideOutput output{};
};

/// One search. Nothing is kept from one pair to the next, or in the store: after a restart the search begins again.
class WideOverlap {
 public:
  /// Whether a search for this pair has begun.
  [[nodiscard]] bool at_work(std::int64_t frame_id, std::int64_t keyframe_id) const {
    return frame_id == frame_id_ && keyframe_id == keyframe_id_;
  }
  /// Prepares the search for a pair; the images are not needed afterwards, until finish(). `before` is the result
  /// without the search. Returns the faults of prepare_wide_search().
  Status begin(std::int64_t frame_id, std::int64_t keyframe_id, const OverlapTemplate& keyframe, GrayView image,
               const OverlapResult& before, double min_overlap, OverlapWorkspace& workspace);
  /// Submits or collects the next job. Returns `done` if no job is left.
  Result<ComputeProgress> go_on(Compute& compute);
  /// Ends the search. `result` is that of the search if it has found the overlap, otherwise `before` of begin().
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
