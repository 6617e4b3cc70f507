// A number of the score against an axis of the grid: a dot for each flight, a line through the means.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/tools/campaign/campaign_file.hpp"
#include "sim/tools/campaign/job_grid.hpp"
#include "sim/tools/campaign/result_table.hpp"

namespace ilp::batch {

struct SweepSeries {
  std::string name;
  std::vector<std::pair<double, double>> dots;   ///< x, y of each flight that has both
  std::vector<std::pair<double, double>> means;  ///< rising in x; empty where x is a number of the score
};

struct SweepPlot {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;  ///< numbers that are not positive are left out then
  std::vector<std::string> x_names;   ///< not empty: x counts these from 0
  std::vector<SweepSeries> series;
  std::size_t without_number = 0;  ///< flights of the plot that failed, were not run or lack the number
};

/// Flights without the plot's axes stay out. An axis with a value that is no number is drawn as names, in the order of
/// the grids.
[[nodiscard]] SweepPlot sweep_plot(const PlotRequest& request, const std::vector<Job>& jobs, const JobResults& results);

/// An <svg> element, in the style of `sweep_style`.
[[nodiscard]] std::string draw(const SweepPlot& plot);

/// The same as a file of its own.
[[nodiscard]] std::string svg_file(const SweepPlot& plot);

[[nodiscard]] const char* sweep_style();

}  // namespace ilp::batch
