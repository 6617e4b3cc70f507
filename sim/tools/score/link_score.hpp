// The links of a flight against the ground that its keyframes truly have in common.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// A keyframe that sees an earlier one's ground again, as the flight verified it.
struct LinkedPair {
  std::int64_t newer = 0, older = 0;  ///< ids of keyframes
};

/// Two keyframes have common ground if each sees 30 % of the other's, hidden ground left out (world::true_overlap). The
/// newer one sees the older one's ground again if they have common ground and are of different strips, or if a keyframe
/// between them in their strip has none with the newer one: what the chain itself keeps in view is no return.
struct LinkScore {
  static constexpr double common_ground = 0.3;

  std::size_t keyframes = 0;                ///< with a true frame
  std::size_t returned = 0, linked = 0;     ///< keyframes that see ground again; those linked with any such ground
  std::size_t pairs = 0, pairs_linked = 0;  ///< pairs of a keyframe and an earlier one whose ground it sees again
  std::size_t links = 0, false_links = 0;   ///< of keyframes with a true frame; those that see nothing of each other

  [[nodiscard]] double linked_share() const { return share(linked, returned); }
  [[nodiscard]] double pairs_linked_share() const { return share(pairs_linked, pairs); }

 private:
  static double share(std::size_t part, std::size_t whole) {
    return whole == 0 ? unknown : static_cast<double>(part) / static_cast<double>(whole);
  }
};

/// The links of the flight's records, those that were verified.
[[nodiscard]] std::vector<LinkedPair> links_of(const intake::Flight& flight);

[[nodiscard]] LinkScore score_links(const intake::Flight& flight, std::span<const LinkedPair> links, TrueFrames& truth);

}  // namespace ilp::score
