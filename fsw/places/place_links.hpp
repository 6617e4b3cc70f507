// Compares a keyframe with places of earlier keyframes, and links it to those that show the same ground.
#pragma once

#include "fsw/places/place_recall.hpp"

namespace ilp {

class PlaceLinks : public PlacePart {
 public:
  PlaceLinks(const PlaceWiring& wiring, const Cursor& cursor, PlaceWork& work, PlaceWorkspace& workspace)
      : PlacePart(wiring, cursor, work, workspace), recall_(wiring, cursor, work, workspace) {}

  // One slice of the phase of this name.
  Status search();
  Status compare();

 private:
  void add_candidate(std::size_t slot);
  template <typename Places>
  void add_candidates(const Places& places);
  void judge(LinkRecord& link, const PoseRecord& place);
  Status register_patches(const PlaceRecord& place, LinkPoints& points);
  void match_features();
  void match_patches();
  void add_match(float older_x, float older_y, float older_depth, float x, float y);
  Status relate(std::uint64_t link_id, LinkGeometry& geometry);
  Status link_with(const RememberedPlace& place, const PlaceRecord& record);

  PlaceRecall recall_;
};

}  // namespace ilp
