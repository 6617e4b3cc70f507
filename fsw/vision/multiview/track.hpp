// Tracks: one corner followed through consecutive keyframes, some of which may miss it, and its point once it is known.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

enum class TrackPhase : std::uint8_t {
  open,         ///< no point yet
  point,        ///< position known, still adjusted
  final_point,  ///< never changes again, waits to be handed out
  removed
};

/// Keyframes are counted by ordinals. Observation k belongs to `first + k`. A keyframe between two observations that
/// does not show the corner has a place in the track, which is missing and unused.
struct Track {
  double position[3] = {0, 0, 0};                   ///< world
  std::array<float, limits::max_track_length> x{};  ///< ideal px
  std::array<float, limits::max_track_length> y{};
  std::uint32_t first = 0;    ///< ordinal of observation 0
  std::uint16_t used = 0;     ///< bit k: observation k takes part; the others were outliers
  std::uint16_t missing = 0;  ///< bit k: keyframe `first + k` has no observation
  std::uint16_t corner = 0;   ///< of the last observation
  std::uint8_t count = 0;     ///< observations and missing ones
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
/// The bits of all observations, outliers included.
[[nodiscard]] inline std::uint16_t observed_bits(const Track& track) {
  return static_cast<std::uint16_t>(((1U << track.count) - 1U) & ~static_cast<std::uint32_t>(track.missing));
}
/// Ordinal after the last observation.
[[nodiscard]] inline std::uint32_t end_of(const Track& track) {
  return track.first + track.count;
}

/// Whether keyframe `ordinal` has an observation.
[[nodiscard]] inline bool sees(const Track& track, std::size_t ordinal) {
  return ordinal >= track.first && ordinal < end_of(track) && ((track.missing >> (ordinal - track.first)) & 1U) == 0;
}

/// A track with one observation.
[[nodiscard]] Track begin_track(std::uint32_t ordinal, std::uint16_t corner, double x, double y);
/// Adds the observation of ordinal end_of(track), which must be less than max_track_length after the first. The track
/// grows.
void extend(Track& track, std::uint16_t corner, double x, double y);
/// The keyframes from end_of(track) up to `ordinal`, without it, miss the corner. The same bound holds.
void miss_until(Track& track, std::uint32_t ordinal);
/// Drops observations before `ordinal`; true if a used one was dropped.
bool shorten(Track& track, std::uint32_t ordinal);

/// Drops the observation of `ordinal`, if there is one, and counts the later keyframes one lower.
void leave_out(Track& track, std::uint32_t ordinal);

/// Maps each corner of keyframe `ordinal` to the growing track that ended there.
void map_corners(const Tracks& tracks, std::uint32_t ordinal, TrackOfCorner& track_of_corner);
/// The same for an older keyframe: its corners are the observations that its tracks use, in table order. Returns their
/// number, at most max_corners.
std::size_t list_corners(const Tracks& tracks, std::uint32_t ordinal, TrackOfCorner& track_of_corner);
/// Removes tracks that no longer grow, shortest first and in table order among equals, until `wanted` places are free
/// or none is left to remove. Final points stay. Returns the number removed.
std::uint32_t make_room(Tracks& tracks, std::size_t wanted);
/// Closes the gaps of removed tracks; the order is kept.
void compact(Tracks& tracks);

}  // namespace ilp
