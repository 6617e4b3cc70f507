// Computes jobs on the flight's own processor, a few units in each call of ask().
#pragma once

#include <array>

#include "hal/compute/compute.hpp"

namespace ilp {

using ComputeForms = std::array<ComputeForm, compute_kinds>;

class CpuCompute final : public Compute {
 public:
  explicit CpuCompute(const ComputeForms& forms) : forms_(forms) {}

  Status submit(const ComputeJob& job) override;
  ComputeProgress ask(ComputeKind kind) override;
  void drop(ComputeKind kind) override { places_[static_cast<std::size_t>(kind)].busy = false; }
  [[nodiscard]] bool on_device() const override { return false; }

  [[nodiscard]] const ComputeForm& form(ComputeKind kind) const { return forms_[static_cast<std::size_t>(kind)]; }
  /// Returns `invalid_argument` for a job that submit() refuses.
  Status check(const ComputeJob& job) const;
  /// Computes one unit of a job, whether the job was submitted or not. `output` has ComputeForm::unit_bytes bytes.
  void compute(ComputeKind kind, std::span<const std::byte> input, std::size_t unit, std::span<std::byte> output) const;

 private:
  struct Place {
    ComputeJob job;
    std::size_t next = 0;  ///< unit to compute next
    bool busy = false;
  };

  const ComputeForms& forms_;
  std::array<Place, compute_kinds> places_{};
};

}  // namespace ilp
