// A device as long as it answers in time and rightly, then the processor. The bytes are the same; an event tells of it.
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "hal/compute/cpu/cpu_compute.hpp"

namespace ilp {

/// A row of results, 16 bytes for each pixel.
inline constexpr std::size_t max_compute_unit_bytes = std::size_t{16} * limits::max_rectified_width;

class GuardedCompute final : public Compute {
 public:
  explicit GuardedCompute(const ComputeForms& forms) : cpu_(forms) {}

  /// Compares the device with the processor on examples of every kind of job, unit by unit, and uses it from then on.
  /// It waits for the device, so call it before the flight. `outputs` is scratch for the largest output, as `inputs`
  /// for the largest input. `compute_refused` (a = ComputeFault, b = kind): the device is left, and never used.
  Status accept(ComputeDevice& device, std::span<std::byte> inputs, std::span<std::byte> outputs);
  /// Mission time stands still: ask() waits for the device, so that no minor frame passes meanwhile.
  void wait_for_answers() { patient_ = true; }

  Status submit(const ComputeJob& job) override;
  ComputeProgress ask(ComputeKind kind) override;
  void drop(ComputeKind kind) override;

  /// `compute_ready`, `compute_refused` or `compute_lost` once, then ok.
  [[nodiscard]] Status take_updates();
  [[nodiscard]] bool on_device() const override { return device_ != nullptr; }

 private:
  ComputeFault compare(ComputeDevice& device, ComputeKind kind, std::span<std::byte> input,
                       std::span<std::byte> output);
  [[nodiscard]] ComputeFault check_unit(ComputeKind kind, std::size_t unit, std::span<const std::byte> input,
                                        std::span<const std::byte> output);
  ComputeProgress ask_device(ComputeKind kind);
  /// All jobs of the device are begun again on the processor.
  void abandon(ComputeKind kind, ComputeFault fault);

  struct Place {
    ComputeJob job;
    bool on_device = false;
  };

  CpuCompute cpu_;
  ComputeDevice* device_ = nullptr;
  bool patient_ = false;
  std::uint64_t checks_ = 0;  ///< jobs that a device has done: each is checked in another unit
  Status updates_;
  std::array<Place, compute_kinds> places_{};
  std::array<std::byte, max_compute_unit_bytes> unit_{};
};

}  // namespace ilp
