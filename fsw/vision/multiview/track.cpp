#include "fsw/vision/multiview/track.hpp"

#include <bit>

namespace ilp {

std::uint32_t used_count(const Track& track) {
  return static_cast<std::uint32_t>(std::popcount(track.used));
}

Track begin_track(std::uint32_t ordinal, std::uint16_t corner, double x, double y) {
  Track track;
  track.first = ordinal;
  extend(track, corner, x, y);
  return track;
}

void extend(Track& track, std::uint16_t corner, double x, double y) {
  track.x[track.count] = static_cast<float>(x);
  track.y[track.count] = static_cast<float>(y);
  track.used = static_cast<std::uint16_t>(track.used | (1U << track.count));
  track.corner = corner;
  track.growing = true;
  ++track.count;
}

void miss_until(Track& track, std::uint32_t ordinal) {
  for (; end_of(track) < ordinal; ++track.count) {  // bound: the window; `count` grows
    track.x[track.count] = track.y[track.count] = 0;
    track.missing = static_cast<std::uint16_t>(track.missing | (1U << track.count));
  }
}

bool shorten(Track& track, std::uint32_t ordinal) {
  if (track.first >= ordinal) return false;
  const std::uint32_t gone = ordinal - track.first < track.count ? ordinal - track.first : track.count;
  const bool used_one = (track.used & ((1U << gone) - 1U)) != 0;
  track.count = static_cast<std::uint8_t>(track.count - gone);
  for (std::uint32_t k = 0; k < track.count; ++k) {
    track.x[k] = track.x[k + gone];
    track.y[k] = track.y[k + gone];
  }
  track.used = static_cast<std::uint16_t>(track.used >> gone);
  track.missing = static_cast<std::uint16_t>(track.missing >> gone);
  track.first += gone;
  return used_one;
}

void leave_out(Track& track, std::uint32_t ordinal) {
  if (ordinal < track.first) {
    --track.first;
    return;
  }
  if (ordinal >= end_of(track)) return;
  const std::uint32_t gone = ordinal - track.first;
  const auto below = static_cast<std::uint32_t>((1U << gone) - 1U);
  const auto without = [&](std::uint16_t bits) {
    return static_cast<std::uint16_t>((bits & below) | ((static_cast<std::uint32_t>(bits) >> 1U) & ~below));
  };
  track.used = without(track.used);
  track.missing = without(track.missing);
  --track.count;
  for (std::uint32_t k = gone; k < track.count; ++k) {
    track.x[k] = track.x[k + 1];
    track.y[k] = track.y[k + 1];
  }
}

void map_corners(const Tracks& tracks, std::uint32_t ordinal, TrackOfCorner& track_of_corner) {
  track_of_corner.fill(no_track);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Track& track = tracks[i];
    if (track.growing && end_of(track) == ordinal + 1) track_of_corner[track.corner] = static_cast<std::uint16_t>(i);
  }
}

std::size_t list_corners(const Tracks& tracks, std::uint32_t ordinal, TrackOfCorner& track_of_corner) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < tracks.size() && count < track_of_corner.size(); ++i) {
    const Track& track = tracks[i];
    const bool grown = track.phase == TrackPhase::open || track.phase == TrackPhase::point;
    if (!grown || !sees(track, ordinal) || !uses(track, ordinal - track.first)) continue;
    track_of_corner[count++] = static_cast<std::uint16_t>(i);
  }
  return count;
}

std::uint32_t make_room(Tracks& tracks, std::size_t wanted) {
  std::uint32_t removed = 0;
  std::size_t free_places = Tracks::capacity() - tracks.size();
  for (std::uint32_t length = 0; length <= limits::max_track_length && free_places < wanted; ++length) {
    for (std::size_t i = 0; i < tracks.size() && free_places < wanted; ++i) {
      Track& track = tracks[i];
      if (track.growing || track.phase == TrackPhase::final_point || track.phase == TrackPhase::removed) continue;
      if (used_count(track) != length) continue;
      track.phase = TrackPhase::removed;
      ++free_places;
      ++removed;
    }
  }
  if (removed > 0) compact(tracks);
  return removed;
}

void compact(Tracks& tracks) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (tracks[i].phase == TrackPhase::removed) continue;
    if (kept != i) tracks[kept] = tracks[i];
    ++kept;
  }
  // Shrinking cannot fail.
  (void)tracks.resize(kept);
}

}  // namespace ilp
