// Scores the links of a flight (place recognition) against the true common ground of its keyframes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// A verified link of the flight: the newer keyframe sees ground of the older keyframe again.
struct LinkedPair {
  std::int64_t newer = 0, older = 0;  ///< ids of keyframes
};

/// Two keyframes have common ground if each sees at least the share `common_ground` of the other's visible ground
/// (world::true_overlap). A keyframe returns to an older keyframe with common ground if they belong to different
/// strips, or if any keyframe between them in their strip has no common ground with the newer keyframe. Ground that the
/// strip has kept in view all the time is no return.
struct LinkScore {
  static constexpr double common_ground = 0.3;

  std::size_t keyframes = 0;                ///< keyframes with a true frame
  std::size_t returned = 0, linked = 0;     ///< keyframes that return; those with a link to such an older keyframe
  std::size_t pairs = 0, pairs_linked = 0;  ///< pairs of a returning and an older keyframe; those with a link
  std::size_t links = 0, false_links = 0;   ///< links of keyframes with a true frame; those without any common ground

  [[nodiscard]] double linked_share() const { return share(linked, returned); }
  [[nodiscard]] double pairs_linked_share() const { return share(pairs_linked, pairs); }

 private:
  static double share(std::size_t part, std::size_t whole) {
    return whole == 0 ? unknown : static_cast<double>(part) / static_cast<double>(whole);
  }
};

/// The links in the flight's records, which the flight has verified.
[[nodiscard]] std::vector<LinkedPair> links_of(const intake::Flight& flight);

[[nodiscard]] LinkScore score_links(const intake::Flight& flight, std::span<const LinkedPair> links, TrueFrames& truth);

}  // namespace ilp::score
