// The onboard masks against what was truly newly seen, and how completely that came down with a depth.
#pragma once

#include <cstddef>
#include <map>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// An earlier pair has not seen ground as well that lay farther from it by more than this factor: claim_ratio of the
/// flight's parameters.
inline constexpr double finer_sampling = 1.8;

/// Counts of pixels, so that keyframes add up. A true mask is that of decisions.md, 9: ground that the keyframe and its
/// partner see and that no earlier pair of the flight, of any strip, has seen with both and as well
/// (world::newly_seen_mask); without a partner all ground that no earlier pair has seen. Pixels that no matcher can
/// match (borders, blank ground) count as missed.
struct MaskScore {
  std::size_t masked = 0, newly_seen = 0, both = 0;  ///< onboard mask, true mask, in both
  std::size_t bytes = 0;   ///< of image and depth as received; also of keyframes without a pose
  double bytes_again = 0;  ///< of `bytes`: for ground that an earlier pair has seen, by its share of the mask's pixels
  std::size_t double_coded = 0;  ///< of `masked`: ground that an earlier mask of the strip has claimed already
  std::size_t expected = 0;      ///< true mask of keyframes that have a next one in their strip to be matched with
  std::size_t with_depth = 0;    ///< of `expected`: with a depth on the ground

  [[nodiscard]] double precision() const { return share(both, masked); }
  [[nodiscard]] double recall() const { return share(both, newly_seen); }
  [[nodiscard]] double double_coded_share() const { return share(double_coded, masked); }
  [[nodiscard]] double bytes_again_share() const {
    return bytes == 0 ? unknown : bytes_again / static_cast<double>(bytes);
  }
  [[nodiscard]] double completeness() const { return share(with_depth, expected); }
  void add(const MaskScore& other);

 private:
  static double share(std::size_t part, std::size_t whole) {
    return whole == 0 ? unknown : static_cast<double>(part) / static_cast<double>(whole);
  }
};

/// The scores by keyframe, for keyframes with a true frame. Pixels are counted for those with a final pose and a mask,
/// bytes for those with a product; an image without a mask is sent as a whole.
[[nodiscard]] std::map<std::int64_t, MaskScore> score_masks(const intake::Flight& flight, TrueFrames& truth);

}  // namespace ilp::score
