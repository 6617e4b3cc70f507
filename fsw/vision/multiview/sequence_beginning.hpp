// Begins a structure from more than two keyframes (paper 3.2). Keyframes wait without poses, connected by tracks, until
// the expected depth error of a pair is small enough. The pair gives the points, and the other keyframes get their
// poses from these points: first the keyframe that sees most of them, whether it was taken before the pair, between its
// two images, or after it.
#pragma once

#include "fsw/vision/multiview/sequence_tracks.hpp"

namespace ilp {

class SequenceBeginning : public SequencePart {
 public:
  SequenceBeginning(SequenceState& state, SequenceWorkspace& workspace)
      : SequencePart(state, workspace), tracks_(state, workspace) {}

  [[nodiscard]] bool relates(const TwoViewResult& pair) const;
  [[nodiscard]] double promise(const TwoViewResult& pair) const;
  /// Begins the structure with the current keyframe and the one before it.
  Status begin_structure();
  /// Adds the current keyframe to those that wait, and ranks the pair that it forms with the one before it.
  void gather(const TwoViewResult& pair);
  // Slices of the phases `rank`, `begin` and `extend_from_pair`.
  Status rank();
  Status begin_with_candidate();
  Status extend_from_pair();

 private:
  void keep_candidate(std::size_t a, std::size_t b, const TwoViewResult& pair);
  Status estimate_pair(std::size_t a, std::size_t b, std::uint64_t seed, TwoViewResult& pair);
  Status decide_by_others(RigidTransform& b_from_a);
  void fill_pairs(std::size_t a, std::size_t b);
  [[nodiscard]] std::size_t next_to_extend();
  void keep_waiting(bool candidate_failed);
  void drop_camera(std::size_t index);
  void lay_world();

  SequenceTracks tracks_;
};

}  // namespace ilp
