// The kinds of compute job of this flight, and the object that computes them on the processor or a device
// (docs/compute.md).
#pragma once

#include <span>

#include "fsw/imaging/wide_overlap.hpp"
#include "hal/compute/guarded_compute.hpp"

namespace ilp {

class FlightCompute {
 public:
  FlightCompute() : forms_{wide_search_form(wide_)}, compute_(forms_) {}

  [[nodiscard]] const ComputeForms& forms() const { return forms_; }
  GuardedCompute& compute() { return compute_; }
  /// Calls GuardedCompute::accept() before the start of the flight. `scratch` is used only during the call.
  Status accept(ComputeDevice& device, WideJob& scratch) {
    return compute_.accept(device, std::as_writable_bytes(std::span(&scratch.input, 1)),
                           std::as_writable_bytes(std::span(&scratch.output, 1)));
  }

 private:
  WideWorkspace wide_{};
  ComputeForms forms_;
  GuardedCompute compute_;
};

}  // namespace ilp
