#include "fsw/terrain/band_jobs.hpp"

#include "fsw/base/checksum.hpp"

namespace ilp {
namespace {

// A few milliseconds of a slow processor.
constexpr std::size_t units_per_call = 8;
// A comparison computes half of a band or more, and a pair has 15 to 25 of them.
constexpr std::size_t jobs_per_check = 16;

void match_unit(void* workspace, std::span<const std::byte> input, std::size_t unit, std::span<std::byte> output) {
  compute_stereo_band_unit(*reinterpret_cast<const StereoBandInput*>(input.data()), unit,
                           *static_cast<StereoBandWorkspace*>(workspace), output);
}

void write_example(void* workspace, std::uint32_t number, std::span<std::byte> input) {
  make_stereo_band_example(number, *static_cast<StereoBandWorkspace*>(workspace),
                           *reinterpret_cast<StereoBandInput*>(input.data()));
}

}  // namespace

ComputeForm stereo_band_form(StereoBandWorkspace& workspace) {
  return {sizeof(StereoBandInput),
          stereo_band_units,
          stereo_band_unit_bytes,
          units_per_call,
          match_unit,
          write_example,
          &workspace,
          jobs_per_check,
          job_layout<StereoBandInput, StereoBandOutput>()};
}

void BandJobs::begin(StereoWorkspace& memory, StereoBandJob& job, StereoMatcher& matcher) {
  if (submitted()) compute_->drop(ComputeKind::stereo_band);
  progress_ = ComputeProgress::none;
  if (compute_ == nullptr || !compute_->on_device()) return;
  StereoMatcher::lend(memory, *workspace_);
  static_cast<void>(matcher.match_in_bands(job));
}

Result<bool> BandJobs::get(StereoMatcher& matcher, StereoBandJob& job) {
  // A job that is gone begins again.
  if (!submitted()) {
    matcher.describe_band();
    ILP_TRY(compute_->submit(
        {ComputeKind::stereo_band, memory_of(job.input), std::as_writable_bytes(std::span(&job.output, 1))}));
  }
  progress_ = compute_->ask(ComputeKind::stereo_band);
  if (progress_ != ComputeProgress::done) return false;
  matcher.take_band();
  return true;
}

}  // namespace ilp
