// Pictures of an evaluation.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/tools/richness/evaluation.hpp"

namespace ilp::richness {

/// ROC curves of every kind of feature and of all, a page of its own as SVG.
[[nodiscard]] std::string roc_svg(const std::vector<EvaluatedImage>& images);

/// Newly seen strips of the keyframes of a range, from the highest index (top left) to the lowest, `count` of them
/// evenly chosen from the ranking of all that are interesting or plain; green frames for interesting ones, red for
/// plain ones.
void write_contact_sheet(const std::filesystem::path& path, const WorldRange& range, const RichnessParams& params,
                         int count, std::size_t threads);

}  // namespace ilp::richness
