// Maintains the tracks of a strip: extends them with each keyframe, triangulates their points, drops observations that
// do not fit, and makes points final.
#pragma once

#include "fsw/vision/multiview/sequence_part.hpp"

namespace ilp {

class SequenceTracks : public SequencePart {
 public:
  using SequencePart::SequencePart;

  /// The corners (real px) of the keyframe `back` before the newest posed one: those that belong to tracks.
  void corners_of(std::uint32_t back, Corners& corners) const;
  [[nodiscard]] std::size_t count_corners(std::uint32_t back) const;
  /// Fills track_of_corner of the workspace for the corners of the base, the keyframe that the current one is matched
  /// with. Returns the number of these corners. If the base is older than the newest keyframe, only corners that belong
  /// to tracks are known.
  std::size_t map_base();
  /// Returns the position of a match in the base, ideal px. Valid after map_base() until a camera is added.
  [[nodiscard]] Vec2 seen_from_base(const Match& match) const;
  /// Fills the workspace's pairs: the matches as pairs of ideal px.
  void fill_pairs();
  /// Fills the workspace's views: the matches that have known points, for the resection.
  void collect_known_points();

  /// Extends and begins tracks with the matches of the newest keyframe.
  void extend();
  Status triangulate();
  Status prune();
  /// Makes the points that only final cameras see final, or removes them if they do not fit.
  void finish();
  /// See Sequence.
  bool take_final_point(FinalPoint& point);
};

}  // namespace ilp
