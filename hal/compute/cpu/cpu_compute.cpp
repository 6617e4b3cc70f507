#include "hal/compute/cpu/cpu_compute.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"

namespace ilp {

Status CpuCompute::check(const ComputeJob& job) const {
  if (job.kind >= ComputeKind::count) return out_of_range(Argument::job_kind, static_cast<std::uint32_t>(job.kind));
  const ComputeForm& form = forms_[static_cast<std::size_t>(job.kind)];
  if (job.input.size() != form.input_bytes) return out_of_range(Argument::job_input, job.input.size());
  if (job.output.size() != form.output_bytes()) return out_of_range(Argument::job_output, job.output.size());
  return {};
}

Status CpuCompute::submit(const ComputeJob& job) {
  ILP_TRY(check(job));
  places_[static_cast<std::size_t>(job.kind)] = {job, 0, true};
  return {};
}

ComputeProgress CpuCompute::ask(ComputeKind kind) {
  Place& place = places_[static_cast<std::size_t>(kind)];
  if (!place.busy) return ComputeProgress::none;
  const ComputeForm& form = forms_[static_cast<std::size_t>(kind)];
  const std::size_t end = std::min(place.next + form.units_per_call, form.units);
  for (; place.next < end; ++place.next) {
    compute(kind, place.job.input, place.next, place.job.output.subspan(place.next * form.unit_bytes, form.unit_bytes));
  }
  if (place.next < form.units) return ComputeProgress::working;
  place.busy = false;
  return ComputeProgress::done;
}

void CpuCompute::compute(ComputeKind kind, std::span<const std::byte> input, std::size_t unit,
                         std::span<std::byte> output) const {
  const ComputeForm& form = forms_[static_cast<std::size_t>(kind)];
  form.compute(form.workspace, input, unit, output);
}

}  // namespace ilp
