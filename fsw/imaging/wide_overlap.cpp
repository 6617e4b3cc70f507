#include "fsw/imaging/wide_overlap.hpp"

#include <array>
#include <cstring>
#include <span>

#include "fsw/base/checksum.hpp"
#include "fsw/base/math.hpp"

namespace ilp {
namespace {

using PoseResult = std::array<std::uint32_t, wide_max_shifts>;
static_assert(sizeof(PoseResult) * wide_job_poses == sizeof(WideOutput));

constexpr std::size_t poses_per_call = 2;

void search_unit(void* workspace, std::span<const std::byte> input, std::size_t unit, std::span<std::byte> output) {
  PoseResult best;
  search_wide_pose(*reinterpret_cast<const WideInput*>(input.data()), unit, *static_cast<WideWorkspace*>(workspace),
                   best);
  std::memcpy(output.data(), best.data(), sizeof(best));
}

void write_example(void*, std::uint32_t number, std::span<std::byte> input) {
  make_wide_example(number, *reinterpret_cast<WideInput*>(input.data()));
}

}  // namespace

ComputeForm wide_search_form(WideWorkspace& workspace) {
  return {sizeof(WideInput), wide_job_poses, sizeof(PoseResult), poses_per_call,
          search_unit,       write_example,  &workspace,         job_layout<WideInput, WideOutput>()};
}

Status WideOverlap::begin(std::int64_t frame_id, std::int64_t keyframe_id, const OverlapTemplate& keyframe,
                          GrayView image, const OverlapResult& before, double min_overlap, OverlapWorkspace& w) {
  const int level = wide_search_level(keyframe.pyramid);
  ILP_TRY(w.b.build(image, coarse_max_side));
  ILP_TRY(prepare_wide_search(keyframe.pyramid.level(level), w.b.level(level), min_overlap, memory_.input, plan_));
  candidates_.clear();
  before_ = before;
  job_ = 0;
  submitted_ = false;
  frame_id_ = frame_id;
  keyframe_id_ = keyframe_id;
  return {};
}

Result<ComputeProgress> WideOverlap::go_on(Compute& compute) {
  if (!submitted_) {
    fill_wide_job(plan_, job_, memory_.input);
    ILP_TRY(compute.submit(
        {ComputeKind::wide_search, memory_of(memory_.input), std::as_writable_bytes(std::span(&memory_.output, 1))}));
    submitted_ = true;
    return ComputeProgress::working;
  }
  const ComputeProgress progress = compute.ask(ComputeKind::wide_search);
  // A job that is gone begins again.
  if (progress == ComputeProgress::none) submitted_ = false;
  if (progress != ComputeProgress::done) return submitted_ ? progress : ComputeProgress::working;
  collect_wide_peaks(plan_, job_, memory_.input, memory_.output, candidates_);
  submitted_ = false;
  return ++job_ < plan_.jobs() ? ComputeProgress::working : ComputeProgress::done;
}

Status WideOverlap::finish(const OverlapTemplate& keyframe, GrayView image, OverlapWorkspace& w,
                           OverlapResult& result) {
  frame_id_ = keyframe_id_ = 0;
  OverlapParams params;
  params.min_overlap = plan_.min_overlap;
  params.max_rotation_rad = pi;
  params.max_scale = coarse_max_scale;
  OverlapResult found;
  ILP_TRY(measure_overlap_of(keyframe, image, candidates_, params, w, found));
  result = found.verdict == OverlapVerdict::ok ? found : before_;
  return {};
}

void WideOverlap::drop(Compute& compute) {
  if (submitted_) compute.drop(ComputeKind::wide_search);
  submitted_ = false;
  frame_id_ = keyframe_id_ = 0;
}

}  // namespace ilp
