// Removes ground that earlier keyframes have seen from the mask of a keyframe.
#pragma once

#include "fsw/places/place_part.hpp"

namespace ilp {

class PlaceMarks : public PlacePart {
 public:
  using PlacePart::PlacePart;

  // One slice of the phases `narrow` and `cut`.
  Status mark_known_ground();
  Status cut_mask();

 private:
  Status load_seen(std::int64_t keyframe_id, SeenCells& cells);
  Status load_mask();
  /// This function and the mark_by functions below mark ground that one earlier keyframe has seen: the keyframe with
  /// index `left` in their list. If the list is shorter, they subtract its length from `left` and return false.
  Result<bool> mark_by(const LinkRecord& link, std::size_t& left);
  Result<bool> mark_by_one_of(const NearPlaces& near, const Similarity& cam_from_strip, double error_px,
                              std::size_t& left);
  Status mark_seen_by(const NearPlace& near, const Similarity& cam_from_strip, double error_px);
  [[nodiscard]] Vec3 ground_here() const;
  [[nodiscard]] bool comes_back_to(const RememberedPlace& place, const RememberedPlace& before) const;
  [[nodiscard]] bool lies_inside(const RememberedPlace& before) const;
  Result<double> error_by_poses(const RememberedPlace& place);
  Result<bool> mark_by_poses(std::size_t& left);
  Result<bool> mark_by_links_before(std::size_t& left);
  Result<bool> mark_by_link_of(std::int64_t linked_id, const LinkRecord& link, std::size_t& left);
  Result<bool> mark_next();
};

}  // namespace ilp
