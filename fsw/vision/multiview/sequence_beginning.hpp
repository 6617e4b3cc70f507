// The beginning of a structure with more than two keyframes (paper 3.2). Keyframes gather without poses, in tracks,
// until a pair of them promises enough. The pair gives the points; the others get their poses from these, the keyframe
// that sees most of them first, whether it was taken before the pair, between its two images, or after it.
#pragma once

#include "fsw/vision/multiview/sequence_tracks.hpp"

namespace ilp {

class SequenceBeginning : public SequencePart {
 public:
  SequenceBeginning(SequenceState& state, SequenceWorkspace& workspace)
      : SequencePart(state, workspace), tracks_(state, workspace) {}

  [[nodiscard]] bool relates(const TwoViewResult& pair) const;
  [[nodiscard]] double promise(const TwoViewResult& pair) const;
  /// With the keyframe at work and the one before it.
  Status begin_structure();
  /// The keyframe at work joins those that wait, and is ranked with them.
  void gather(const TwoViewResult& pair);
  // Slices: of the phases `rank`, `begin` and `surround`.
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
