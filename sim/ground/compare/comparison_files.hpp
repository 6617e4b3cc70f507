// What a comparison leaves for people and programs beside the raster.
#pragma once

#include <filesystem>

#include "sim/ground/compare/comparison.hpp"

namespace ilp::compare {

/// comparison.json, comparison.html, difference.png. Throws std::runtime_error when the folder cannot be written.
void write_comparison_files(const Comparison& comparison);

}  // namespace ilp::compare
