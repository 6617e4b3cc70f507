// Defaults for what makes an image rich, from images with known truth.
#pragma once

#include <vector>

#include "sim/tools/richness/evaluation.hpp"

namespace ilp::richness {

/// Halves: for every cue the geometric mean of its medians over the plain and over the interesting images, so that the
/// squashed cue changes most between the two. Weights: logistic regression of the label on the squashed cues, the
/// weights not negative (projected gradient descent, a little weight decay), every kind of feature and the plain images
/// counting alike; then scaled to a sum of 10 and not below `least_weight`, so that no cue is silent: worlds that
/// nobody thought of may need it. All rounded to two digits. Images without terrain are left out.
[[nodiscard]] RichnessParams fit_richness(std::vector<EvaluatedImage> images, double least_weight = 0.3);

}  // namespace ilp::richness
