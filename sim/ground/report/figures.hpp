// Pieces of figures on a page: a picture inside SVG, with lines, labels, scale bar and legend over it.
#pragma once

#include <array>
#include <string>

#include "sim/ground/report/plan_view.hpp"

namespace ilp::report {

/// Picture px.
using PicturePoint = std::array<double, 2>;

/// With one decimal.
[[nodiscard]] std::string px(double value);
/// The opening tag with the picture in it; figure() closes it.
[[nodiscard]] std::string open_svg(const host::Raster<host::Rgba>& picture, const std::string& label);
[[nodiscard]] std::string segment(const PicturePoint& a, const PicturePoint& b, const char* style);
/// `anchor`: start, middle or end.
[[nodiscard]] std::string label(double x, double y, const char* anchor, const std::string& text);
[[nodiscard]] std::string scale_bar(const PlanView& view, const std::string& unit);
/// What the colours mean: title, colours over the range, unit; for a picture of this width in px.
[[nodiscard]] std::string colour_legend(const std::string& title, const host::ValueRange& range,
                                        const std::string& unit, std::int32_t width,
                                        host::ColourMap colours = host::viridis);
/// An arrow at the lower right of the view that points to where `x`, `y` of the world point, with its name.
[[nodiscard]] std::string direction_arrow(const PlanView& view, double x, double y, const std::string& name);
[[nodiscard]] std::string figure(const std::string& svg, const std::string& caption);

/// The beginning of a page with the report's style sheet, up to <main>.
[[nodiscard]] std::string begin_page(const std::string& title);

}  // namespace ilp::report
