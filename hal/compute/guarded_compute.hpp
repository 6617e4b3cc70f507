// Uses a compute device while it answers in time and correctly, and the processor after its first fault. The results
// have the same bytes; an event reports the change.
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "hal/compute/cpu/cpu_compute.hpp"

namespace ilp {

/// Limit of ComputeForm::unit_bytes: a row of results with 16 bytes for each pixel.
inline constexpr std::size_t max_compute_unit_bytes = std::size_t{16} * limits::max_rectified_width;

class GuardedCompute final : public Compute {
 public:
  explicit GuardedCompute(const ComputeForms& forms) : cpu_(forms) {}

  /// Compares the device with the processor on examples of every kind of job, unit by unit. Uses the device from then
  /// on if all bytes agree; it outlives this object. The call waits for the device and belongs before the flight.
  /// `inputs` is scratch with the size of the largest input, `outputs` with that of the largest output. Returns
  /// `compute_refused` (first value: ComputeFault, second: ComputeKind) if the device is not used.
  Status accept(ComputeDevice& device, std::span<std::byte> inputs, std::span<std::byte> outputs);
  /// For flights in virtual time: ask() waits for the device, so that a job ends in the same minor frame in every run.
  void wait_for_answers() { patient_ = true; }

  Status submit(const ComputeJob& job) override;
  ComputeProgress ask(ComputeKind kind) override;
  void drop(ComputeKind kind) override;

  /// Returns `compute_ready`, `compute_refused` or `compute_lost` once after the change that it reports, otherwise ok.
  [[nodiscard]] Status take_updates();
  [[nodiscard]] bool on_device() const override { return device_ != nullptr; }

 private:
  ComputeFault compare(ComputeDevice& device, ComputeKind kind, std::span<std::byte> input,
                       std::span<std::byte> output);
  [[nodiscard]] ComputeFault check_unit(ComputeKind kind, std::size_t unit, std::span<const std::byte> input,
                                        std::span<const std::byte> output);
  ComputeProgress ask_device(ComputeKind kind);
  /// Leaves the device and begins all of its jobs again on the processor.
  void abandon(ComputeKind kind, ComputeFault fault);

  struct Place {
    ComputeJob job;
    bool on_device = false;
  };

  CpuCompute cpu_;
  ComputeDevice* device_ = nullptr;
  bool patient_ = false;
  std::uint64_t checks_ = 0;  ///< jobs done by the device; the processor checks one unit of each, chosen by this number
  Status updates_;
  std::array<Place, compute_kinds> places_{};
  std::array<std::byte, max_compute_unit_bytes> unit_{};
};

}  // namespace ilp
