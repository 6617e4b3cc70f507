// The flight against the truth, from a score.

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/ground/report/page_sections.hpp"
#include "sim/ground/report/score_file.hpp"
#include "sim/host/metrics.hpp"
#include "sim/host/picture.hpp"
#include "sim/host/svg_plot.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

// Pictures of a flight against the truth.

constexpr double page_width = 1120;

struct Point {
  double x = 0, y = 0;
};

struct TrackStop {
  std::int64_t id = 0;
  Point truth, error;  // along and across the flight, truth's unit
};

std::vector<TrackStop> stops_of(const ScoredStrip& strip) {
  std::vector<TrackStop> stops;
  if (!strip.up || !strip.forward) return stops;
  const Vec3 left = strip.up->cross(*strip.forward);
  for (const ScoredKeyframe& k : strip.keyframes) {
    if (!k.true_centre || !k.aligned_centre) continue;
    const Vec3 error = *k.aligned_centre - *k.true_centre;
    stops.push_back({k.id,
                     {strip.forward->dot(*k.true_centre), left.dot(*k.true_centre)},
                     {strip.forward->dot(error), left.dot(error)}});
  }
  return stops;
}

// 1, 2 or 5 times a power of ten, at most `value`.
double round_down(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {5.0, 2.0}) {
    if (value >= factor * power) return factor * power;
  }
  return power;
}

// The largest error becomes about a twentieth of the track.
double exaggeration(const std::vector<TrackStop>& stops) {
  double largest = 0, extent = 0;
  for (const TrackStop& s : stops) {
    largest = std::max(largest, std::hypot(s.error.x, s.error.y));
    extent = std::max(extent, std::hypot(s.truth.x - stops[0].truth.x, s.truth.y - stops[0].truth.y));
  }
  const double ratio = largest > 0 ? 0.05 * extent / largest : 0;
  return ratio > 1 && ratio < 1e9 ? round_down(ratio) : 1;
}

struct Frame {
  double left = 0, top = 0, px_per_unit = 1, width = page_width, height = 0;
  [[nodiscard]] std::string at(const Point& p) const {
    return host::fixed((p.x - left) * px_per_unit, 1) + "," + host::fixed((top - p.y) * px_per_unit, 1);
  }
};

Point estimate(const TrackStop& s, double factor) {
  return {s.truth.x + factor * s.error.x, s.truth.y + factor * s.error.y};
}

Frame frame_of(const std::vector<TrackStop>& stops, double factor) {
  Point low = stops[0].truth, high = stops[0].truth;
  for (const TrackStop& s : stops) {
    for (const Point& p : {s.truth, estimate(s, factor)}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  constexpr double margin = 36, tallest = 520;
  const double along = std::max(high.x - low.x, 1e-12), across = std::max(high.y - low.y, 1e-12);
  Frame frame;
  frame.px_per_unit = std::min((page_width - 2 * margin) / along, tallest / across);
  const double side = 0.5 * (page_width / frame.px_per_unit - along);
  frame.left = low.x - side;
  frame.top = high.y + margin / frame.px_per_unit;
  frame.height = std::max(110.0, across * frame.px_per_unit + 2 * margin + 24);
  return frame;
}

std::string polyline(const Frame& frame, const std::vector<TrackStop>& stops, double factor, const char* style) {
  std::string svg = std::string("<polyline class=\"line ") + style + "\" points=\"";
  for (const TrackStop& s : stops) svg += frame.at(estimate(s, factor)) + " ";
  return svg + "\"/>";
}

std::string arrow(const Frame& frame, const TrackStop& s, double factor) {
  return "<polyline class=\"line s2\" points=\"" + frame.at(s.truth) + " " + frame.at(estimate(s, factor)) + "\"/>";
}

std::string dot(const Frame& frame, const Point& p, const char* style, const std::string& title) {
  const std::string at = frame.at(p);
  const std::size_t comma = at.find(',');
  return std::string("<circle class=\"dot ") + style + "\" cx=\"" + at.substr(0, comma) + "\" cy=\"" +
         at.substr(comma + 1) + "\" r=\"3\"><title>" + host::escaped(title) + "</title></circle>";
}

std::string scale_bar(const Frame& frame) {
  const double length = round_down(0.16 * page_width / frame.px_per_unit), px = length * frame.px_per_unit;
  const double x = page_width - 20 - px, y = frame.height - 14;
  return "<line class=\"bar-line\" x1=\"" + host::fixed(x, 1) + "\" x2=\"" + host::fixed(x + px, 1) + "\" y1=\"" +
         host::fixed(y, 1) + "\" y2=\"" + host::fixed(y, 1) + "\"/><text class=\"tick\" text-anchor=\"middle\" x=\"" +
         host::fixed(x + 0.5 * px, 1) + "\" y=\"" + host::fixed(y - 6, 1) + "\">" + host::brief(length) + "</text>";
}

struct CoveredBox {
  std::int32_t left = 0, top = 0, right = -1, bottom = -1;
};

CoveredBox covered_box(const host::Raster<float>& map) {
  CoveredBox box{map.width, map.height, -1, -1};
  for (std::int32_t y = 0; y < map.height; ++y) {
    for (std::int32_t x = 0; x < map.width; ++x) {
      if (!std::isfinite(map.at(x, y))) continue;
      box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x), std::max(box.bottom, y)};
    }
  }
  return box;
}

// Means of square blocks, so that the picture is at most as wide as the page.
host::Raster<float> reduced(const host::Raster<float>& map, const CoveredBox& box) {
  const std::int32_t wide = box.right - box.left + 1, high = box.bottom - box.top + 1;
  const std::int32_t block = std::max(1, (std::max(wide, 2 * high) + 1119) / 1120);
  host::Raster<float> small((wide + block - 1) / block, (high + block - 1) / block, std::nanf(""));
  for (std::int32_t y = 0; y < small.height; ++y) {
    for (std::int32_t x = 0; x < small.width; ++x) {
      double sum = 0;
      int cells = 0;
      for (std::int32_t j = 0; j < block; ++j) {
        for (std::int32_t i = 0; i < block; ++i) {
          const std::int32_t u = box.left + x * block + i, v = box.top + y * block + j;
          if (!map.contains(u, v) || !std::isfinite(map.at(u, v))) continue;
          sum += map.at(u, v);
          ++cells;
        }
      }
      if (cells > 0) small.at(x, y) = static_cast<float>(sum / cells);
    }
  }
  return small;
}

std::string colour_bar(const host::ValueRange& range) {
  std::string gradient;
  for (int i = 0; i <= 10; ++i) {
    const host::Rgb c = host::diverging(i / 10.0);
    gradient +=
        (i == 0 ? "rgb(" : ",rgb(") + std::to_string(c.r) + "," + std::to_string(c.g) + "," + std::to_string(c.b) + ")";
  }
  return "<span class=\"tick\">" + host::brief(range.low) +
         "</span> <span class=\"colours\" style=\"background:linear-gradient(90deg," + gradient + ")\"></span> <span>" +
         host::brief(range.high) + "</span>";
}

/// True and estimated track from above, flight from left to right, errors drawn larger than they are; a <figure>,
/// empty where there is no track.
std::string track_error_figure(const ScoredStrip& strip) {
  const std::vector<TrackStop> stops = stops_of(strip);
  if (stops.size() < 2) return "";
  const double factor = exaggeration(stops);
  const Frame frame = frame_of(stops, factor);
  std::string svg = "<svg class=\"plot\" viewBox=\"0 0 " + host::fixed(page_width, 0) + " " +
                    host::fixed(frame.height, 0) + "\" role=\"img\" aria-label=\"true and estimated track\">";
  svg += polyline(frame, stops, 0, "s1") + polyline(frame, stops, factor, "s2 dashed");
  for (const TrackStop& s : stops) {
    const std::string name = "keyframe " + std::to_string(s.id);
    svg += arrow(frame, s, factor) + dot(frame, s.truth, "s1", name + ", true") +
           dot(frame, estimate(s, factor), "s2", name + ", off by " + host::brief(std::hypot(s.error.x, s.error.y)));
  }
  return "<figure>" + svg + scale_bar(frame) + "</svg><figcaption>Strip " + std::to_string(strip.id) +
         " from above, flight from left to right: <span class=\"key s1\"></span> true track, <span class=\"key s2\">"
         "</span> estimated track, laid onto it by a similarity, its errors " +
         (factor == 1 ? std::string("to scale") : host::brief(factor) + " times larger than they are") +
         ".</figcaption></figure>\n";
}

/// The map of height errors in colours, cut to what was mapped; a <figure>, empty without a map.
std::string height_error_figure(const ScoreFile& score) {
  const CoveredBox box = covered_box(score.height_error);
  if (box.right < box.left) return "";
  const host::Raster<float> map = reduced(score.height_error, box);
  host::ValueRange range = host::display_range(map);
  // Zero lies in the middle, so that colour distinguishes too high from too low.
  range.high = std::max(std::fabs(range.low), std::fabs(range.high));
  range.low = -range.high;
  const std::string w = std::to_string(map.width), h = std::to_string(map.height);
  return "<figure><svg viewBox=\"0 0 " + w + " " + h + "\" role=\"img\" aria-label=\"height errors\"><image width=\"" +
         w + "\" height=\"" + h + "\" href=\"" +
         host::data_uri(host::png_bytes(host::colour_mapped(map, range, host::diverging))) +
         "\"/></svg><figcaption>Errors of the merged heights on the truth's grid, strip laid onto the truth: too low " +
         colour_bar(range) + " too high, in the truth's unit. Blank: not mapped.</figcaption></figure>\n";
}

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
  plot.x_label = "distance flown, truth's unit";
  plot.y_label = "truth's unit";
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
  plot.y_label = "strip unit";
  host::PlotSeries sigma{"estimated, 1 sigma", "s1", host::Mark::line, {}},
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
  const double target = std::isfinite(score.target_overlap) ? score.target_overlap : report.target_overlap;
  if (std::isfinite(target)) plot.target = 100 * target;
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
