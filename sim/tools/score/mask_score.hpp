// Scores the onboard masks against the ground that was truly newly seen, and the depths of this ground for
// completeness.
#pragma once

#include <cstddef>
#include <map>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

/// Ground is newly seen although an earlier pair has seen it, if its distance from the earlier pair was larger by more
/// than this factor (claim_ratio of the flight's parameters).
inline constexpr double finer_sampling = 1.8;

/// Counts of pixels and bytes, which add up over keyframes. The true mask (decisions.md, 9) is the ground that the
/// keyframe and its partner see, and that no earlier pair of the flight has seen with both images and equally well
/// (world::newly_seen_mask). Pairs of all strips count. Without a partner it is all ground that no earlier pair has
/// seen. Pixels that no matcher can match (borders, blank ground) count as missed.
struct MaskScore {
  std::size_t masked = 0, newly_seen = 0, both = 0;  ///< in the onboard mask, in the true mask, in both
  std::size_t bytes = 0;   ///< image and depth products as received; also of keyframes without a pose
  double bytes_again = 0;  ///< part of `bytes` for ground that an earlier pair has seen, from its share of the pixels
  std::size_t double_coded = 0;  ///< pixels of `masked` on ground in the mask of any earlier keyframe
  std::size_t expected = 0;      ///< true mask with the next posed keyframe of the strip as partner
  std::size_t with_depth = 0;    ///< pixels of `expected` with a downlinked depth

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

/// Scores by keyframe id, for keyframes with a true frame. Pixels are counted for keyframes with a final pose and a
/// mask, bytes for keyframes with a product. A product without a mask counts as the entire image.
[[nodiscard]] std::map<std::int64_t, MaskScore> score_masks(const intake::Flight& flight, TrueFrames& truth);

}  // namespace ilp::score
