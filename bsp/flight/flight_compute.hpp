// The jobs of this flight, and what does them: the processor, or a device beside it (docs/compute.md).
#pragma once

#include <span>

#include "fsw/imaging/wide_overlap.hpp"
#include "fsw/terrain/dense_matcher.hpp"
#include "hal/compute/guarded_compute.hpp"

namespace ilp {

class FlightCompute {
 public:
  FlightCompute() : forms_{wide_search_form(wide_), stereo_band_form(bands_)}, compute_(forms_) {}

  [[nodiscard]] const ComputeForms& forms() const { return forms_; }
  GuardedCompute& compute() { return compute_; }
  StereoBandWorkspace& bands() { return bands_; }
  /// Compares the device with the processor and uses it, before the start of the flight; all jobs fit into `spare`. See
  /// GuardedCompute::accept().
  Status accept(ComputeDevice& device, StereoBandJob& spare) {
    static_assert(sizeof(WideInput) <= sizeof(StereoBandInput) && sizeof(WideOutput) <= sizeof(StereoBandOutput));
    return compute_.accept(device, std::as_writable_bytes(std::span(&spare.input, 1)),
                           std::as_writable_bytes(std::span(&spare.output, 1)));
  }

 private:
  WideWorkspace wide_{};
  StereoBandWorkspace bands_;
  ComputeForms forms_;
  GuardedCompute compute_;
};

}  // namespace ilp
