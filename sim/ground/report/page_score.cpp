// The flight against the truth, from a score.
#include <algorithm>
#include <cmath>

#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/score_figures.hpp"
#include "sim/host/metrics.hpp"
#include "sim/host/svg_plot.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

constexpr const char* styles[] = {"s1", "s2", "s3", "s4"};
constexpr std::size_t most_strips = 4;

// Longest first, so that what is drawn is the larger part of the flight; then in order.
std::vector<const ScoredStrip*> drawn_strips(const ScoreFile& score) {
  std::vector<const ScoredStrip*> strips;
  for (const ScoredStrip& strip : score.strips) {
    if (strip.length > 0 && std::isfinite(strip.position_mean_percent)) strips.push_back(&strip);
  }
  std::stable_sort(strips.begin(), strips.end(),
                   [](const ScoredStrip* a, const ScoredStrip* b) { return a->length > b->length; });
  strips.resize(std::min(strips.size(), most_strips));
  std::sort(strips.begin(), strips.end(), [](const ScoredStrip* a, const ScoredStrip* b) { return a->id < b->id; });
  return strips;
}

using Strips = std::vector<const ScoredStrip*>;

std::string strip_name(const ScoredStrip& strip) {
  return "strip " + std::to_string(strip.id);
}

host::Plot along_strip(const char* title) {
  host::Plot plot;
  plot.title = title;
  plot.x_label = "distance flown";
  plot.counts = false;
  return plot;
}

template <typename Value>
host::PlotSeries strip_series(const ScoredStrip& strip, const std::string& name, const char* style, host::Mark mark,
                              Value value) {
  host::PlotSeries series{name, style, mark, {}};
  for (const ScoredKeyframe& k : strip.keyframes) {
    if (std::isfinite(k.distance) && std::isfinite(value(k))) series.points.emplace_back(k.distance, value(k));
  }
  return series;
}

host::Plot position_plot(const Strips& strips) {
  host::Plot plot = along_strip("Position error");
  const bool one = strips.size() == 1;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    plot.series.push_back(strip_series(*strips[i], one ? "whole strip aligned" : strip_name(*strips[i]), styles[i],
                                       host::Mark::line, [](const ScoredKeyframe& k) { return k.position_error; }));
  }
  return plot;
}

host::Plot drift_plot(const Strips& strips) {
  host::Plot plot = along_strip("Position error with only the begin aligned: drift");
  for (std::size_t i = 0; i < strips.size(); ++i) {
    plot.series.push_back(strip_series(*strips[i], strip_name(*strips[i]), styles[i], host::Mark::line,
                                       [](const ScoredKeyframe& k) { return k.drift_error; }));
  }
  return plot;
}

host::PlotSeries bow_curve(const ScoredStrip& strip, const char* style) {
  host::PlotSeries curve{"bow", style, host::Mark::curve, {}};
  for (int i = 0; i <= 40; ++i) {
    const double u = i / 20.0 - 1;
    const Vec3& fit = *strip.bow_fit;
    curve.points.emplace_back(0.5 * (u + 1) * strip.length, fit[0] + u * (fit[1] + u * fit[2]));
  }
  return curve;
}

host::Plot height_plot(const Strips& strips) {
  host::Plot plot = along_strip("Height error along the strip, with its bow");
  plot.target = 0;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const bool one = strips.size() == 1;
    plot.series.push_back(strip_series(*strips[i], one ? "cameras" : strip_name(*strips[i]), styles[i],
                                       host::Mark::dots, [](const ScoredKeyframe& k) { return k.height_error; }));
    if (strips[i]->bow_fit) plot.series.push_back(bow_curve(*strips[i], styles[one ? 1 : i]));
    if (!one || strips[i]->surface_error.empty()) continue;
    plot.series.push_back({"merged ground, median", "s3", host::Mark::curve, strips[i]->surface_error});
  }
  return plot;
}

host::Plot scale_plot(const Strips& strips) {
  host::Plot plot = along_strip("Local scale against the strip's mean");
  plot.y_label = "%";
  plot.target = 0;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    plot.series.push_back(strip_series(*strips[i], strip_name(*strips[i]), styles[i], host::Mark::line,
                                       [](const ScoredKeyframe& k) { return 100 * (k.local_scale - 1); }));
  }
  return plot;
}

host::Plot sigma_plot(const ScoreFile& score) {
  host::Plot plot;
  plot.title = "Position relative to the first pair: sigma and error";
  plot.x_label = "keyframe";
  host::PlotSeries sigma{"stated, 1 sigma", "s1", host::Mark::line, {}},
      error{"actual error", "s2", host::Mark::dots, {}};
  for (const ScoredKeyframe& k : score.keyframes) {
    if (!k.sigma || !k.relative_error) continue;
    sigma.points.emplace_back(static_cast<double>(k.id), k.sigma->norm());
    error.points.emplace_back(static_cast<double>(k.id), k.relative_error->norm());
  }
  plot.series = {sigma, error};
  return plot;
}

host::Plot overlap_plot(const Report& report, const ScoreFile& score) {
  host::Plot plot;
  plot.title = "Overlap of each keyframe with the one before";
  plot.x_label = "keyframe";
  plot.y_label = "%";
  plot.from_zero = false;
  plot.target = 100 * (std::isfinite(score.target_overlap) ? score.target_overlap : report.target_overlap);
  plot.target_name = "target";
  host::PlotSeries stated{"stated", "s1", host::Mark::dots, {}}, truth{"true", "s2", host::Mark::dots, {}};
  for (const ScoredKeyframe& k : score.keyframes) {
    if (std::isfinite(k.overlap)) stated.points.emplace_back(static_cast<double>(k.id), 100 * k.overlap);
    if (std::isfinite(k.true_overlap)) truth.points.emplace_back(static_cast<double>(k.id), 100 * k.true_overlap);
  }
  plot.series = {stated};
  if (!truth.points.empty()) plot.series.push_back(truth);
  return plot;
}

std::string value_text(const ScoreFile& score, const char* key) {
  const auto found = score.summary.find(key);
  return found == score.summary.end() ? "–" : host::score_text(found->second);
}

std::string score_table(const ScoreFile& score) {
  std::string html = "<h3>Scores</h3>\n<div class=\"columns\">\n", group;
  for (const host::Metric& metric : host::metrics()) {
    if (*metric.group == '\0') continue;
    if (group != metric.group) {
      html += (group.empty() ? "" : "</table></div>\n") +
              std::string("<div class=\"scroll\"><table><tr><th class=\"t\">") + metric.group +
              "</th><th>score</th><th>perfect</th></tr>\n";
      group = metric.group;
    }
    html += "<tr>" + cell(metric.label, "t w") + cell(value_text(score, metric.key)) + cell(metric.ideal) + "</tr>\n";
  }
  return html + "</table></div>\n</div>\n";
}

std::string remarks_list(const ScoreFile& score) {
  if (score.remarks.empty()) return "";
  std::string html = "<ul class=\"note\">";
  for (const std::string& remark : score.remarks) html += "<li>" + host::escaped(remark) + "</li>";
  return html + "</ul>\n";
}

}  // namespace

std::string page_score(const Report& report) {
  if (!report.score) return "";
  const ScoreFile& score = *report.score;
  const Strips strips = drawn_strips(score);
  std::string html = "<h2>Against the truth</h2>\n";
  if (!score.complete) html += "<p class=\"warn\">The flight is not complete; it is scored as far as it went.</p>\n";
  if (strips.size() < score.strips.size()) {
    html += "<p class=\"note\">" + host::counted(strips.size(), "strip") + " of " +
            std::to_string(score.strips.size()) +
            " drawn: the longest with poses enough to be measured. The scores are of all.</p>\n";
  }
  html += "<p class=\"note\">Lengths are in the truth's unit: metres where it was simulated.</p>\n";
  for (const ScoredStrip* strip : strips) html += track_error_figure(*strip);
  html += "<div class=\"plots\">\n";
  if (!strips.empty()) {
    for (const host::Plot& plot :
         {position_plot(strips), drift_plot(strips), height_plot(strips), scale_plot(strips)}) {
      html += host::svg_plot(plot) + "\n";
    }
  }
  html += host::svg_plot(sigma_plot(score)) + "\n" + host::svg_plot(overlap_plot(report, score)) + "\n</div>\n";
  return html + height_error_figure(score) + score_table(score) + remarks_list(score);
}

}  // namespace ilp::report
