// Work that a second processor may do beside the flight's own (docs/compute.md). A job is a pure function of its input:
// whoever does it, and whenever, gives the same bytes. Nobody waits for a job: it is submitted, and asked for later.
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

/// What the jobs of a kind are. The results of a job's units lie in its output one after another.
struct ComputeForm {
  std::size_t input_bytes = 0;
  std::size_t units = 0;
  std::size_t unit_bytes = 0;      ///< of output
  std::size_t units_per_call = 1;  ///< that the processor does while it is asked once
  /// The processor's function, which a device must give the bytes of.
  void (*compute)(void* workspace, std::span<const std::byte> input, std::size_t unit,
                  std::span<std::byte> output) = nullptr;
  /// Writes input `number` of those with which a device is compared at the start.
  void (*example)(void* workspace, std::uint32_t number, std::span<std::byte> input) = nullptr;
  void* workspace = nullptr;
  std::uint64_t layout = 0;  ///< job_layout() of input and output

  [[nodiscard]] constexpr std::size_t output_bytes() const { return units * unit_bytes; }
};

/// Changes with the fields of a job's input or output.
template <typename Input, typename Output>
constexpr std::uint64_t job_layout() {
  return 3 * layout_digest<Input>() + layout_digest<Output>();
}

struct ComputeJob {
  ComputeKind kind = ComputeKind::count;
  std::span<const std::byte> input;  ///< unchanged until the job is done or dropped
  std::span<std::byte> output;
};

enum class ComputeProgress : std::uint8_t {
  none,     ///< there is no such job
  working,  ///< it goes on each time it is asked for
  waiting,  ///< a device does it: ask in the next minor frame
  done      ///< the output is written, and the job is over
};

class Compute {
 public:
  Compute() = default;
  Compute(const Compute&) = delete;
  Compute& operator=(const Compute&) = delete;

  /// There is one job of each kind at a time; another one takes its place. `invalid_argument` (the kind, bytes of
  /// input, bytes of output).
  virtual Status submit(const ComputeJob& job) = 0;
  virtual ComputeProgress ask(ComputeKind kind) = 0;
  virtual void drop(ComputeKind kind) = 0;
  /// Whether a device does the jobs.
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

/// A device that does jobs. It is never waited for in flight.
class ComputeDevice {
 public:
  ComputeDevice() = default;
  ComputeDevice(const ComputeDevice&) = delete;
  ComputeDevice& operator=(const ComputeDevice&) = delete;

  virtual ComputeFault begin(const ComputeJob& job) = 0;
  /// Whether the output of the latest job of this kind is written now; a fault ends the use of the device.
  virtual ComputeFault ask(ComputeKind kind, bool& done) = 0;
  /// Returns when there may be updates, or after a millisecond at most. Only where mission time stands still.
  virtual void pause() = 0;
  /// Nothing is asked of it any more.
  virtual void leave() = 0;

 protected:
  ~ComputeDevice() = default;
};

}  // namespace ilp
