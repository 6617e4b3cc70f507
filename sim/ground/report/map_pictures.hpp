// The pictures of maps that the pages draw over (page/figures.js), and where the world lies in them.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim/ground/report/plan_view.hpp"
#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// Takes a PNG by a name such as `strip-1-heights`, and returns the address by which the page finds it.
using KeepPicture = std::function<std::string(const std::string& name, const std::vector<std::uint8_t>& png)>;
using TakeFigure = std::function<void(const std::string& name, const nlohmann::ordered_json& figure)>;

/// {"view":{"width","height","cosine","sine","along_low","across_high","unit_per_px"},"href"}, as PlanView has them. A
/// coloured picture also has "range", the values at the ends of "colours".
[[nodiscard]] nlohmann::ordered_json picture_json(const PlanView& view, const std::string& address);
[[nodiscard]] nlohmann::ordered_json coloured_picture_json(const PlanView& view, const std::string& address,
                                                           const host::ValueRange& range, host::ColourMap colours);

/// Gives these figures, of what is there:
///   strip ID        orthoimage; "laid" where it is also laid on interpolated ground; "north": direction in the world,
///                   or null; "heights": coloured, with "exaggeration" of its shading
///   landing ID      coloured by the probability; "footprint_px"
///   fixes ID        north up; "href" null without the image of the map, "other_map" where another one is at hand
///   height errors   coloured
void map_figures(const Report& report, const KeepPicture& keep, const TakeFigure& take);

}  // namespace ilp::report
