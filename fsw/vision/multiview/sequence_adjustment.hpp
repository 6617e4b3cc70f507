// Adjusts the window of a strip, one iteration at a time, and estimates the errors of the result.
#pragma once

#include "fsw/vision/multiview/sequence_part.hpp"

namespace ilp {

class SequenceAdjustment : public SequencePart {
 public:
  using SequencePart::SequencePart;

  /// Does one iteration. After the last one it computes the covariance of the result instead, and phase `errors`
  /// follows. If there is nothing to adjust, phase `next` follows.
  Status adjust(std::uint32_t max_iterations, SequencePhase errors, SequencePhase next);
  void state_errors(std::uint32_t max_iterations, SequencePhase next);

 private:
  [[nodiscard]] BundleParams bundle_params(std::uint32_t max_iterations) const;
  Status finish_adjustment();
  void write_errors();
};

}  // namespace ilp
