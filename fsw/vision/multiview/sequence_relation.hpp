// Computes the pose of the current keyframe: two-view relation to the keyframe that it is matched with, choice between
// the motions of the first pair, and resection from known points (paper 3.2).
#pragma once

#include "fsw/vision/multiview/sequence_beginning.hpp"

namespace ilp {

class SequenceRelation : public SequencePart {
 public:
  SequenceRelation(SequenceState& state, SequenceWorkspace& workspace)
      : SequencePart(state, workspace), tracks_(state, workspace), beginning_(state, workspace) {}

  // Slices of the phases `relate`, `relating`, `decide` and `resect`.
  Status relate();
  Status go_on_relating();
  Status decide();
  Status resect_camera();

 private:
  Status take_relation(const TwoViewResult& pair);
  Status take_rival_motion();
  [[nodiscard]] bool plausible(const ResectionResult& resection);

  SequenceTracks tracks_;
  SequenceBeginning beginning_;
};

}  // namespace ilp
