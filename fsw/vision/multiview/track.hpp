// Tracks: a track is one corner followed through consecutive keyframes, some of which may miss it, and its point when
// it is known.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

enum class TrackPhase : std::uint8_t {
  open,         ///< no point yet
  point,        ///< position known and still adjusted
  final_point,  ///< position final; waits for take_final_point
  removed
};

/// A track. Keyframes are counted by ordinals, and observation k belongs to keyframe `first + k`. A keyframe between
/// two observations that does not show the corner has an element in the track, which is missing and not used.
struct Track {
  double position[3] = {0, 0, 0};                   ///< world
  std::array<float, limits::max_track_length> x{};  ///< ideal px
  std::array<float, limits::max_track_length> y{};
  std::uint32_t first = 0;    ///< ordinal of observation 0
  std::uint16_t used = 0;     ///< bit k: observation k is used; observations that are not used were outliers
  std::uint16_t missing = 0;  ///< bit k: keyframe `first + k` has no observation
  std::uint16_t corner = 0;   ///< corner index of the last observation
  std::uint8_t count = 0;     ///< number of observations, missing ones included
  bool growing = false;       ///< the next keyframe may extend it
  TrackPhase phase = TrackPhase::open;
};
static_assert(limits::max_track_length <= 16, "Track::used has 16 bits");
using Tracks = FixedVector<Track, limits::max_tracks>;

inline constexpr std::uint16_t no_track = 0xFFFF;
using TrackOfCorner = std::array<std::uint16_t, limits::max_corners>;

[[nodiscard]] inline bool uses(const Track& track, std::uint32_t k) {
  return ((track.used >> k) & 1U) != 0;
}
[[nodiscard]] std::uint32_t used_count(const Track& track);
/// Returns one bit per observation, outliers included, missing ones excluded.
[[nodiscard]] inline std::uint16_t observed_bits(const Track& track) {
  return static_cast<std::uint16_t>(((1U << track.count) - 1U) & ~static_cast<std::uint32_t>(track.missing));
}
/// Returns the ordinal after the last observation.
[[nodiscard]] inline std::uint32_t end_of(const Track& track) {
  return track.first + track.count;
}

/// Returns true if keyframe `ordinal` has an observation of the track.
[[nodiscard]] inline bool sees(const Track& track, std::size_t ordinal) {
  return ordinal >= track.first && ordinal < end_of(track) && ((track.missing >> (ordinal - track.first)) & 1U) == 0;
}

/// Returns a track with one observation.
[[nodiscard]] Track begin_track(std::uint32_t ordinal, std::uint16_t corner, double x, double y);
/// Adds an observation by keyframe end_of(track) and marks the track as growing. The track must have fewer than
/// max_track_length elements.
void extend(Track& track, std::uint16_t corner, double x, double y);
/// Adds missing observations for the keyframes from end_of(track) to `ordinal` - 1. The same limit applies.
void miss_until(Track& track, std::uint32_t ordinal);
/// Drops the observations before keyframe `ordinal`. Returns true if a used one was dropped.
bool shorten(Track& track, std::uint32_t ordinal);

/// Removes keyframe `ordinal` from the track: drops its observation, if there is one, and reduces the ordinals of later
/// keyframes by one.
void leave_out(Track& track, std::uint32_t ordinal);

/// Maps each corner of keyframe `ordinal` to the growing track whose last observation it is; no_track if there is none.
void map_corners(const Tracks& tracks, std::uint32_t ordinal, TrackOfCorner& track_of_corner);
/// Does the same for an older keyframe. Its corners are the used observations of tracks that are not final, in the
/// order of the table. Returns their number, at most max_corners.
std::size_t list_corners(const Tracks& tracks, std::uint32_t ordinal, TrackOfCorner& track_of_corner);
/// Removes tracks that no longer grow, those with the fewest observations first and in the order of the table among
/// equals, until `wanted` elements of the table are free or no such track is left. Final points stay. Returns the
/// number removed.
std::uint32_t make_room(Tracks& tracks, std::size_t wanted);
/// Deletes removed tracks from the table; the order of the others is kept.
void compact(Tracks& tracks);

}  // namespace ilp
