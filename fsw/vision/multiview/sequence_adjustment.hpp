// The adjustment of a strip's window, an iteration at a time, and the errors of its result.
#pragma once

#include "fsw/vision/multiview/sequence_part.hpp"

namespace ilp {

class SequenceAdjustment : public SequencePart {
 public:
  using SequencePart::SequencePart;

  /// An iteration, or the covariance of the result, whose errors are stated next; without a result it goes to `next`.
  Status adjust(std::uint32_t max_iterations, SequencePhase errors, SequencePhase next);
  void state_errors(std::uint32_t max_iterations, SequencePhase next);

 private:
  [[nodiscard]] BundleParams bundle_params(std::uint32_t max_iterations) const;
  Status finish_adjustment();
  void write_errors();
};

}  // namespace ilp
