#include "sim/tools/campaign/sweep_plot.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "sim/tools/campaign/summary_keys.hpp"

namespace ilp::batch {
namespace {

std::optional<double> as_number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<double> score_number(const std::optional<JobResult>& result, const std::string& key) {
  if (!result || !result->failure.empty()) return {};
  const auto found = result->score.summary.find(key);
  return found == result->score.summary.end() ? std::nullopt : found->second;
}

/// The values of the axis in the order of the grids; empty where all are numbers.
std::vector<std::string> names_on_axis(const std::string& key, const std::vector<Job>& jobs) {
  std::vector<std::string> names;
  bool numbers = true;
  for (const Job& job : jobs) {
    const std::string* value = axis_value(job, key);
    if (value == nullptr || std::find(names.begin(), names.end(), *value) != names.end()) continue;
    names.push_back(*value);
    numbers = numbers && as_number(*value);
  }
  if (numbers) names.clear();
  return names;
}

std::optional<std::string> series_name(const PlotRequest& request, const Job& job) {
  std::string name;
  for (const std::string& key : request.series) {
    const std::string* value = axis_value(job, key);
    if (value == nullptr) return {};
    name += (name.empty() ? "" : ", ") + *value;
  }
  return name;
}

std::vector<std::pair<double, double>> means_of(const std::vector<std::pair<double, double>>& dots) {
  std::map<double, std::pair<double, std::size_t>> sums;
  for (const auto& [x, y] : dots) {
    sums[x].first += y;
    ++sums[x].second;
  }
  std::vector<std::pair<double, double>> means;
  means.reserve(sums.size());
  for (const auto& [x, sum] : sums) means.emplace_back(x, sum.first / static_cast<double>(sum.second));
  return means;
}

std::string label_of(const std::string& key) {
  const SummaryKey* known = find_summary_key(key);
  return known == nullptr ? key : std::string(known->label);
}

}  // namespace

SweepPlot sweep_plot(const PlotRequest& request, const std::vector<Job>& jobs, const JobResults& results) {
  SweepPlot plot;
  plot.title = request.name;
  plot.x_label = label_of(request.x);
  plot.y_label = label_of(request.y);
  plot.log_x = request.log_x;
  plot.log_y = request.log_y;
  const bool scatter =
      std::none_of(jobs.begin(), jobs.end(), [&](const Job& job) { return axis_value(job, request.x) != nullptr; });
  if (!scatter) plot.x_names = names_on_axis(request.x, jobs);
  if (!plot.x_names.empty()) plot.log_x = false;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const std::optional<std::string> name = series_name(request, jobs[i]);
    const std::string* on_axis = axis_value(jobs[i], request.x);
    if (!name || (!scatter && on_axis == nullptr)) continue;
    auto series = std::find_if(plot.series.begin(), plot.series.end(),
                               [&](const SweepSeries& other) { return other.name == *name; });
    if (series == plot.series.end()) series = plot.series.insert(series, SweepSeries{*name, {}, {}});
    std::optional<double> x = scatter ? score_number(results[i], request.x) : as_number(*on_axis);
    if (!plot.x_names.empty()) {
      x = static_cast<double>(std::find(plot.x_names.begin(), plot.x_names.end(), *on_axis) - plot.x_names.begin());
    }
    const std::optional<double> y = score_number(results[i], request.y);
    const bool shown = x && y && (!plot.log_x || *x > 0) && (!plot.log_y || *y > 0);
    if (shown) {
      series->dots.emplace_back(*x, *y);
    } else {
      ++plot.without_number;
    }
  }
  if (scatter) return plot;
  for (SweepSeries& series : plot.series) series.means = means_of(series.dots);
  return plot;
}

}  // namespace ilp::batch
