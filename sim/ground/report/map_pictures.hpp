// Makes the pictures of maps for the pages (page/figures.js), with the transformation from the world to their pixels.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// Stores a PNG under a name such as `strip-1-heights`, and returns the address by which the page loads it.
using KeepPicture = std::function<std::string(const std::string& name, const std::vector<std::uint8_t>& png)>;
using TakeFigure = std::function<void(const std::string& name, const nlohmann::ordered_json& figure)>;

/// {"view":{"width","height","cosine","sine","along_low","across_high","unit_per_px"},"href"}, with the members of
/// PlanView. A coloured picture also has "colours", and "range" with the values at the ends of the colour scale.
[[nodiscard]] nlohmann::ordered_json picture_json(const PlanView& view, const std::string& address);
[[nodiscard]] nlohmann::ordered_json coloured_picture_json(const PlanView& view, const std::string& address,
                                                           const host::ValueRange& range, host::ColourMap colours);

/// Makes these figures as far as the report has their data:
///   strip ID        orthoimage. "laid": whether it also shows ground on interpolated heights. "north": direction in
///   the
///                   world, or null. "heights": coloured picture with "exaggeration", that of heights in the shading
///   landing ID      picture coloured by the probability of a safe landing. "footprint_px": diameter
///   fixes ID        image of the flight's map, north up. "href" is null without an image, and "other_map" is set if
///   the
///                   available map is another one
///   height errors   coloured picture
void map_figures(const Report& report, const KeepPicture& keep, const TakeFigure& take);

}  // namespace ilp::report
