// The keyframe with which a new one is matched: the newest one of the strip, or one a little older. Of the older ones
// only those corners are known that tracks hold.
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"

namespace ilp {

bool Sequence::can_go_back_to(std::uint32_t back) const {
  // Before there are points, hardly any corner of an older keyframe is in a track that the newest one does not extend.
  // The rival motion of the first pair is kept for the newest keyframe alone.
  return back == 0 || (back < s_.cameras.size() && begun() && !s_.first_pair.ambiguous);
}

void Sequence::corners_of(std::uint32_t back, Corners& corners) const {
  const std::uint32_t ordinal = newest() - back;
  corners.clear();
  const std::size_t count = list_corners(s_.tracks, ordinal, w_.track_of_corner);
  for (std::size_t i = 0; i < count; ++i) {
    const Track& track = s_.tracks[w_.track_of_corner[i]];
    const std::uint32_t k = ordinal - track.first;
    const Vec2 pixel =
        pixel_from_ideal(s_.camera, Vec2(static_cast<double>(track.x[k]), static_cast<double>(track.y[k])));
    (void)corners.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 0});
  }
}

std::size_t Sequence::count_corners(std::uint32_t back) const {
  return list_corners(s_.tracks, newest() - back, w_.track_of_corner);
}

/// Fills w_.track_of_corner for the corners of the base. Returns how many corners there are.
std::size_t Sequence::map_base() {
  if (s_.back > 0) return list_corners(s_.tracks, newest() - s_.back, w_.track_of_corner);
  map_corners(s_.tracks, newest(), w_.track_of_corner);
  return s_.corners.size();
}

/// Ideal px. It holds after map_base() until a camera is added.
Vec2 Sequence::seen_from_base(const Match& match) const {
  if (s_.back == 0) {
    const Corner& corner = s_.corners[match.a];
    return ideal_from_pixel(s_.camera, Vec2(static_cast<double>(corner.x), static_cast<double>(corner.y)));
  }
  const Track& track = s_.tracks[w_.track_of_corner[match.a]];
  const std::uint32_t k = newest() - s_.back - track.first;
  return {static_cast<double>(track.x[k]), static_cast<double>(track.y[k])};
}

}  // namespace ilp
