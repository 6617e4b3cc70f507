// Writes the files of a comparison except the raster: page, picture and JSON.
#pragma once

#include <filesystem>

#include "sim/ground/compare/comparison.hpp"

namespace ilp::compare {

/// Writes comparison.json, comparison.html and difference.png. Throws std::runtime_error if the folder cannot be
/// written.
void write_comparison_files(const Comparison& comparison);

}  // namespace ilp::compare
