#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/host/text_format.hpp"
#include "sim/tools/campaign/sweep_plot.hpp"

namespace ilp::batch {
namespace {

using ground::brief;
using ground::escaped;

constexpr double width = 640, left = 58, right = 16, top = 52, plot_height = 250, tick_room = 44, legend_line = 18;
constexpr std::size_t colours = 6;

std::string px_text(double value) {
  return ground::fixed(value, 1);
}

/// Shortest text that tells neighbouring ticks apart.
std::string tick_text(double value, double step) {
  if (std::fabs(value) < step * 1e-6) return "0";
  if (std::fabs(value) >= 1e6 || step < 1e-5) return brief(value);
  const int decimals = step >= 1 ? 0 : static_cast<int>(std::ceil(-std::log10(step) - 1e-9));
  return ground::fixed(value, decimals);
}

/// A linear or logarithmic scale from values to 0..1, with its ticks.
struct Scale {
  bool logarithmic = false;
  double low = 0, high = 1;
  std::vector<std::pair<double, std::string>> ticks;

  [[nodiscard]] double at(double value) const {
    return logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  }
};

double nice_step(double span) {
  const double raw = span / 6, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

Scale linear_scale(double low, double high, bool whole_steps) {
  if (high - low < 1e-9 * std::max(1.0, std::fabs(high))) {
    const double margin = std::max(std::fabs(high) * 0.1, 1e-6);
    low -= margin;
    high += margin;
  }
  const double step = nice_step(high - low);
  Scale scale;
  const double margin = whole_steps ? 0 : 0.04 * (high - low);
  scale.low = whole_steps ? std::floor(low / step + 1e-9) * step : low - margin;
  scale.high = whole_steps ? std::ceil(high / step - 1e-9) * step : high + margin;
  const auto first = static_cast<int>(std::ceil((scale.low - 1e-9 * step) / step));
  for (int i = first; i * step <= scale.high + 1e-9 * step; ++i) {
    scale.ticks.emplace_back(i * step, tick_text(i * step, step));
  }
  return scale;
}

Scale log_scale(double low, double high) {
  Scale scale;
  scale.logarithmic = true;
  scale.low = low / 1.1;
  scale.high = high * 1.1;
  const bool few = scale.high / scale.low < 100;
  for (double power = std::pow(10.0, std::floor(std::log10(scale.low))); power <= scale.high; power *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * power;
      if ((factor == 1 || few) && value >= scale.low && value <= scale.high) {
        scale.ticks.emplace_back(value, tick_text(value, power));
      }
    }
  }
  return scale;
}

Scale names_scale(const std::vector<std::string>& names) {
  Scale scale;
  scale.low = -0.5;
  scale.high = static_cast<double>(names.size()) - 0.5;
  for (std::size_t i = 0; i < names.size(); ++i) scale.ticks.emplace_back(static_cast<double>(i), names[i]);
  return scale;
}

class Painter {
 public:
  explicit Painter(const SweepPlot& plot) : plot_(plot) {
    double x_low = std::numeric_limits<double>::max(), x_high = -x_low, y_low = x_low, y_high = x_high;
    for (const SweepSeries& series : plot.series) {
      for (const auto& [x, y] : series.dots) {
        x_low = std::min(x_low, x);
        x_high = std::max(x_high, x);
        y_low = std::min(y_low, y);
        y_high = std::max(y_high, y);
      }
    }
    empty_ = !(x_low <= x_high);
    if (empty_) return;
    if (!plot.x_names.empty()) {
      x_ = names_scale(plot.x_names);
    } else {
      x_ = plot.log_x ? log_scale(x_low, x_high) : linear_scale(x_low, x_high, false);
    }
    y_ = plot.log_y ? log_scale(y_low, y_high) : linear_scale(std::min(0.0, y_low), std::max(0.0, y_high), true);
  }

  std::string draw() {
    place_legend();
    text(0, 16, "title", "start", plot_.title);
    if (empty_) {
      text(0.5 * width, top + 0.5 * plot_height, "tick", "middle", "no data");
    } else {
      draw_axes();
      for (std::size_t i = 0; i < plot_.series.size(); ++i) draw_series(plot_.series[i], i % colours + 1);
      draw_legend();
    }
    return "<svg class=\"sweep\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px_text(width) + " " +
           px_text(height_) + "\" role=\"img\" aria-label=\"" + escaped(plot_.title) + "\">" + svg_ + "</svg>";
  }

 private:
  [[nodiscard]] double px(double x) const { return left + x_.at(x) * (width - left - right); }
  [[nodiscard]] double py(double y) const { return top + (1 - y_.at(y)) * plot_height; }

  void text(double x, double y, const char* style, const char* anchor, const std::string& content) {
    svg_ += "<text class=\"" + std::string(style) + "\" x=\"" + px_text(x) + "\" y=\"" + px_text(y) +
            "\" text-anchor=\"" + anchor + "\">" + escaped(content) + "</text>";
  }

  void line(double x0, double y0, double x1, double y1) {
    svg_ += "<line class=\"grid\" x1=\"" + px_text(x0) + "\" y1=\"" + px_text(y0) + "\" x2=\"" + px_text(x1) +
            "\" y2=\"" + px_text(y1) + "\"/>";
  }

  void draw_axes() {
    const double bottom = top + plot_height;
    for (const auto& [value, name] : y_.ticks) {
      line(left, py(value), width - right, py(value));
      text(left - 7, py(value) + 4, "tick", "end", name);
    }
    for (const auto& [value, name] : x_.ticks) {
      line(px(value), bottom, px(value), bottom + 4);
      text(px(value), bottom + 17, "tick", "middle", name);
    }
    text(width - right, bottom + 35, "tick", "end", plot_.x_label);
    text(0, top - 15, "tick", "start", plot_.y_label);
  }

  void draw_series(const SweepSeries& series, std::size_t colour) {
    const std::string style = "c" + std::to_string(colour);
    if (series.means.size() > 1) {
      svg_ += "<polyline class=\"mean " + style + "\" points=\"";
      for (const auto& [x, y] : series.means) svg_ += px_text(px(x)) + "," + px_text(py(y)) + " ";
      svg_.back() = '"';
      svg_ += "/>";
    }
    for (const auto& [x, y] : series.dots) {
      svg_ += "<circle class=\"dot " + style + "\" cx=\"" + px_text(px(x)) + "\" cy=\"" + px_text(py(y)) +
              "\" r=\"3\"><title>" + escaped(series.name) + " " + brief(y) + "</title></circle>";
    }
  }

  struct LegendEntry {
    double x, y;
  };

  void place_legend() {
    double x = left, y = top + plot_height + tick_room + 8;
    for (const SweepSeries& series : plot_.series) {
      const double room = 30 + 6.6 * static_cast<double>(series.name.size());
      if (x > left && x + room > width) {
        x = left;
        y += legend_line;
      }
      legend_.push_back({x, y});
      x += room;
    }
    const bool named = plot_.series.size() > 1 || (!plot_.series.empty() && !plot_.series.front().name.empty());
    if (!named) legend_.clear();
    height_ = legend_.empty() ? top + plot_height + tick_room : legend_.back().y + 10;
  }

  void draw_legend() {
    for (std::size_t i = 0; i < legend_.size(); ++i) {
      const auto [x, y] = legend_[i];
      svg_ += "<circle class=\"dot c" + std::to_string(i % colours + 1) + "\" cx=\"" + px_text(x + 4) + "\" cy=\"" +
              px_text(y - 4) + "\" r=\"4.5\"/>";
      text(x + 13, y, "tick", "start", plot_.series[i].name);
    }
  }

  const SweepPlot& plot_;
  std::string svg_;
  Scale x_, y_;
  std::vector<LegendEntry> legend_;
  double height_ = 0;
  bool empty_ = false;
};

}  // namespace

std::string draw(const SweepPlot& plot) {
  return Painter(plot).draw();
}

std::string svg_file(const SweepPlot& plot) {
  std::string svg = draw(plot);
  svg.insert(svg.find('>') + 1, "<style>" + std::string(sweep_style()) + "</style>");
  return svg + "\n";
}

const char* sweep_style() {
  return R"css(
.sweep{--i:#1d232b;--m:#66707c;--l:#e3e1dc;--b:#fff;--c1:#2b6aa3;--c2:#c8762b;--c3:#4b8a57;--c4:#8a5a9c;--c5:#b3261e;
--c6:#3f8f94;background:var(--b);font:12px system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
@media (prefers-color-scheme:dark){.sweep{--i:#e4e7eb;--m:#98a2ae;--l:#2d333b;--b:#1b1f25;--c1:#6fb0e6;--c2:#eaa45e;
--c3:#7fc48d;--c4:#c193d4;--c5:#f08a80;--c6:#74c3c7}}
.sweep .title{fill:var(--i);font-size:14px;font-weight:600}.sweep .tick{fill:var(--m);font-size:11.5px}
.sweep .grid{stroke:var(--l)}.sweep .mean{fill:none;stroke-width:1.8}.sweep .dot{fill-opacity:.75}
.sweep .mean.c1{stroke:var(--c1)}.sweep .mean.c2{stroke:var(--c2)}.sweep .mean.c3{stroke:var(--c3)}
.sweep .mean.c4{stroke:var(--c4)}.sweep .mean.c5{stroke:var(--c5)}.sweep .mean.c6{stroke:var(--c6)}
.sweep .dot.c1{fill:var(--c1)}.sweep .dot.c2{fill:var(--c2)}.sweep .dot.c3{fill:var(--c3)}
.sweep .dot.c4{fill:var(--c4)}.sweep .dot.c5{fill:var(--c5)}.sweep .dot.c6{fill:var(--c6)}
)css";
}

}  // namespace ilp::batch
