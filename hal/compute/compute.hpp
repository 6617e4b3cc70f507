// Interface for jobs that a compute device, or else the flight's own processor, works on (docs/compute.md). A job is a
// pure function of its input: the processor and every device write the same output bytes at any time. The caller
// submits a job in one minor frame and asks for its progress in later ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/fields.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

enum class ComputeKind : std::uint32_t { wide_search, count };
inline constexpr EnumValue compute_kind_values[] = {{0, "wide_search", "wide search"}};
inline constexpr std::size_t compute_kinds = static_cast<std::size_t>(ComputeKind::count);

/// Sizes and functions of one kind of job. A job consists of `units`, whose results follow each other in its output.
struct ComputeForm {
  std::size_t input_bytes = 0;
  std::size_t units = 0;
  std::size_t unit_bytes = 0;      ///< bytes of one unit's result
  std::size_t units_per_call = 1;  ///< units that the processor computes in one call of Compute::ask()
  /// Computes the result of one unit (0 to units - 1) on the processor. `output` has `unit_bytes` bytes. A device must
  /// give the same bytes.
  void (*compute)(void* workspace, std::span<const std::byte> input, std::size_t unit,
                  std::span<std::byte> output) = nullptr;
  /// Writes an input on which a device is compared with the processor at the start. `number` counts them from 0.
  void (*example)(void* workspace, std::uint32_t number, std::span<std::byte> input) = nullptr;
  void* workspace = nullptr;  ///< scratch that both functions get
  std::uint64_t layout = 0;   ///< job_layout() of input and output

  [[nodiscard]] constexpr std::size_t output_bytes() const { return units * unit_bytes; }
};

/// Fingerprint of the fields of a job's input and output: two programs that agree in it have the same layout.
template <typename Input, typename Output>
constexpr std::uint64_t job_layout() {
  return 3 * layout_digest<Input>() + layout_digest<Output>();
}

struct ComputeJob {
  ComputeKind kind = ComputeKind::count;
  std::span<const std::byte> input;  ///< the caller leaves it unchanged until the job is done or dropped
  std::span<std::byte> output;       ///< complete when ask() returns `done`
};

enum class ComputeProgress : std::uint8_t {
  none,     ///< there is no job of this kind
  working,  ///< the processor computes the next units in each call of ask()
  waiting,  ///< the device computes: ask again in the next minor frame
  done      ///< the output is complete; returned once, then `none`
};

class Compute {
 public:
  Compute() = default;
  Compute(const Compute&) = delete;
  Compute& operator=(const Compute&) = delete;

  /// Begins a job, and drops an unfinished one of the same kind. Returns `invalid_argument` if the kind is unknown, or
  /// the input or output does not have the size of its ComputeForm.
  virtual Status submit(const ComputeJob& job) = 0;
  /// Returns the progress of the job of this kind. On the processor, each call computes `units_per_call` units.
  virtual ComputeProgress ask(ComputeKind kind) = 0;
  /// Drops the job of this kind, if there is one. Its output is undefined.
  virtual void drop(ComputeKind kind) = 0;
  /// Whether jobs are submitted to a device.
  [[nodiscard]] virtual bool on_device() const = 0;

 protected:
  ~Compute() = default;
};

/// Why a device is not used (reasons of the events compute_refused and compute_lost).
ILP_ENUMERATION(ComputeFault, (0, none, ""), (1, late, "no answer within the limit"),
                (2, gone, "its program has ended, or cannot be reached"),
                (3, damaged, "what it wrote does not have its checksum or its place"),
                (4, wrong, "its bytes are not those of the processor"),
                (5, unreachable, "no program listens, or the memory cannot be shared"))

/// A device that computes jobs. The flight never waits for one.
class ComputeDevice {
 public:
  ComputeDevice() = default;
  ComputeDevice(const ComputeDevice&) = delete;
  ComputeDevice& operator=(const ComputeDevice&) = delete;

  /// Hands over the input of a job, which replaces the latest one of its kind. A fault ends the use of the device.
  virtual ComputeFault begin(const ComputeJob& job) = 0;
  /// Sets `done` and writes the output if the latest job of this kind is complete. A fault ends the use of the device.
  virtual ComputeFault ask(ComputeKind kind, bool& done) = 0;
  /// Waits for a result, at most a millisecond. Called only before the flight and in flights in virtual time.
  virtual void pause() = 0;
  /// Ends the use of the device.
  virtual void leave() = 0;

 protected:
  ~ComputeDevice() = default;
};

}  // namespace ilp
