// Draws the results of an evaluation of the richness index.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/tools/richness/evaluation.hpp"

namespace ilp::richness {

/// ROC curves of every kind of feature and of all features, as an SVG document.
[[nodiscard]] std::string roc_svg(const std::vector<EvaluatedImage>& images);

/// Writes a picture with the newly seen parts of `count` keyframes, from the highest index (top left) to the lowest.
/// They are evenly chosen from the ranking of all interesting and plain keyframes of the range. Interesting keyframes
/// have green frames, plain ones red frames.
void write_contact_sheet(const std::filesystem::path& path, const WorldRange& range, const RichnessParams& params,
                         int count, std::size_t threads);

}  // namespace ilp::richness
