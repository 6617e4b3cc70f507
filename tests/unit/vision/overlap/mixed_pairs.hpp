// The mixture of pairs on which the verdicts of the overlap are judged: related, unrelated, repeating, moving, blank
// and mirrored ground. ILP_OVERLAP_TEXTURES and ILP_OVERLAP_STREAM choose the ground and the pairs.
#pragma once

#include <string>

#include "fsw/vision/overlap/overlap.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"

namespace ilp::test {

inline constexpr std::uint32_t textures = 10;
const GroundTexture& texture(std::size_t k);

/// Of a search over a full turn.
OverlapParams any_attitude();

double between(Rng& rng, double low, double high);
double between_ratio(Rng& rng, double low, double high);
/// Somewhere on a texture, in any direction; `texels` per pixel.
Similarity2 somewhere(Rng& rng, double texels);

/// A pair of images of 160 x 120 px, with the true overlap.
struct MixedPair {
  std::string kind;
  Image a, b;
  double truth = 0;
};

MixedPair mixed_pair(int number, bool full_turn);

}  // namespace ilp::test
