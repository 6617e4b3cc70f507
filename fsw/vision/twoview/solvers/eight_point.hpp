// Fundamental matrix by linear least squares, from eight matches or more.
#pragma once

#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// Minimises the sum of (b^T F a)^2 under |F| = 1, then takes the nearest matrix of rank two (R. Hartley, "In Defence
/// of the 8-Point Algorithm", 1995; `pairs` are normalised already). Returns false if there are fewer than eight
/// matches, or if they allow more than one solution (a plane, a line).
bool eight_point(const NormalisedPairs& pairs, const PairSelection& selection, Mat3& fundamental);

}  // namespace ilp
