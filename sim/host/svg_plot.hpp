// Small plots as inline SVG. Colours come from the page's style sheet, so that they follow light and dark.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ilp::host {

/// `line` has a dot at every point, `curve` has none.
enum class Mark { line, curve, dots, bars };

struct PlotSeries {
  std::string name;
  std::string style;  ///< class of the page's style sheet: s1 to s4
  Mark mark = Mark::line;
  std::vector<std::pair<double, double>> points;  ///< values that are not finite are left out
  /// Half lengths of vertical error bars, one per point; empty for none. Those that are not finite are left out.
  std::vector<double> sigmas = {};
};

struct Plot {
  std::string title;
  std::string x_label, y_label;
  std::vector<PlotSeries> series;
  std::optional<double> target;  ///< a dashed level
  std::string target_name;
  bool from_zero = true;
  bool counts = true;  ///< x are whole numbers: keyframes, frames
};

[[nodiscard]] std::string svg_plot(const Plot& plot);

}  // namespace ilp::host
