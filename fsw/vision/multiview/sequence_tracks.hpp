// The tracks of a strip: they grow with each keyframe, become points, lose observations that do not fit, and become
// final.
#pragma once

#include "fsw/vision/multiview/sequence_part.hpp"

namespace ilp {

class SequenceTracks : public SequencePart {
 public:
  using SequencePart::SequencePart;

  /// Corners (real px) of the keyframe `back` before the newest posed one: those of its tracks.
  void corners_of(std::uint32_t back, Corners& corners) const;
  [[nodiscard]] std::size_t count_corners(std::uint32_t back) const;
  /// Fills track_of_corner of the workspace for the corners of the base, the keyframe that the one at work is matched
  /// with. Returns how many corners there are. Of an older one only those are known that tracks hold.
  std::size_t map_base();
  /// Where the base sees a match, in ideal px. It holds after map_base() until a camera is added.
  [[nodiscard]] Vec2 seen_from_base(const Match& match) const;
  /// The matches as pairs of ideal px.
  void fill_pairs();
  /// The matches with points, for the resection.
  void collect_known_points();

  /// Takes in the matches of the newest keyframe.
  void extend();
  Status triangulate();
  Status prune();
  /// Those that only final cameras see become final, or are removed.
  void finish();
  /// See Sequence.
  bool take_final_point(FinalPoint& point);
};

}  // namespace ilp
