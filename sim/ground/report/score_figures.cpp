#include "sim/ground/report/score_figures.hpp"

#include <algorithm>
#include <cmath>

#include "sim/host/colour_map.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

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
    const host::Rgb c = host::viridis(i / 10.0);
    gradient +=
        (i == 0 ? "rgb(" : ",rgb(") + std::to_string(c.r) + "," + std::to_string(c.g) + "," + std::to_string(c.b) + ")";
  }
  return "<span class=\"tick\">" + host::brief(range.low) +
         "</span> <span class=\"colours\" style=\"background:linear-gradient(90deg," + gradient + ")\"></span> <span>" +
         host::brief(range.high) + "</span>";
}

}  // namespace

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
         w + "\" height=\"" + h + "\" href=\"" + host::data_uri(host::png_bytes(host::colour_mapped(map, range))) +
         "\"/></svg><figcaption>Errors of the merged heights on the truth's grid, strip laid onto the truth: too low " +
         colour_bar(range) + " too high, in the truth's unit. Blank: not mapped.</figcaption></figure>\n";
}

}  // namespace ilp::report
