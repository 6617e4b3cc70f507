#include "sim/host/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace {

constexpr double width = 560, height = 230, left = 52, right = 14, top = 34, bottom = 40;

struct Axis {
  double low = 0, high = 1, step = 0.2;
};

double nice_step(double span, int ticks) {
  const double raw = span / ticks, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

Axis nice_axis(double low, double high, int ticks) {
  if (!(low <= high)) return {};
  if (high - low < 1e-12 * std::max(1.0, std::fabs(high))) high = low + std::max(1.0, std::fabs(low) * 0.1);
  Axis axis;
  axis.step = nice_step(high - low, ticks);
  axis.low = std::floor(low / axis.step) * axis.step;
  axis.high = std::ceil(high / axis.step) * axis.step;
  return axis;
}

std::string number(double value) {
  return fixed(value, 1);
}

std::string tick_text(double value, double step) {
  const int decimals = step >= 1 ? 0 : std::min(6, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  if (std::fabs(value) >= 1e4) return fixed(value / 1e3, 0) + "k";
  return fixed(std::fabs(value) < step * 1e-6 ? 0 : value, decimals);
}

double error_of(const PlotSeries& series, std::size_t point) {
  return point < series.sigmas.size() && std::isfinite(series.sigmas[point]) ? series.sigmas[point] : 0;
}

class Painter {
 public:
  explicit Painter(const Plot& plot) : plot_(plot) {
    double x_low = std::numeric_limits<double>::max(), x_high = -x_low, y_low = x_low, y_high = -x_low;
    for (const PlotSeries& series : plot.series) {
      bars_ = bars_ || series.mark == Mark::bars;
      for (std::size_t i = 0; i < series.points.size(); ++i) {
        const auto& [x, y] = series.points[i];
        if (!std::isfinite(x) || !std::isfinite(y)) continue;
        x_low = std::min(x_low, x);
        x_high = std::max(x_high, x);
        y_low = std::min(y_low, y - error_of(series, i));
        y_high = std::max(y_high, y + error_of(series, i));
      }
    }
    empty_ = !(x_low <= x_high);
    if (plot.target) {
      y_low = std::min(y_low, *plot.target);
      y_high = std::max(y_high, *plot.target);
    }
    if (plot.from_zero) y_low = std::min(y_low, 0.0);
    x_ = plot.counts ? Axis{x_low - (bars_ ? 0.6 : 0.25), x_high + (bars_ ? 0.6 : 0.25),
                            std::max(1.0, nice_step(x_high - x_low + 1, 10))}
                     : nice_axis(x_low, x_high, 8);
    y_ = nice_axis(y_low, y_high, 5);
  }

  std::string draw() {
    svg_ = "<svg class=\"plot\" viewBox=\"0 0 " + number(width) + " " + number(height) +
           "\" role=\"img\" aria-label=\"" + escaped(plot_.title) + "\">";
    text(0, 14, "title", "start", plot_.title);
    if (empty_) {
      text(0.5 * width, 0.5 * height, "tick", "middle", "no data");
      return svg_ + "</svg>";
    }
    draw_axes();
    std::size_t bar = 0;
    for (const PlotSeries& series : plot_.series) draw_series(series, bar);
    if (plot_.target) {
      const double y = py(*plot_.target);
      svg_ += "<line class=\"target\" x1=\"" + number(left) + "\" x2=\"" + number(width - right) + "\" y1=\"" +
              number(y) + "\" y2=\"" + number(y) + "\"/>";
      text(width - right, y - 4, "tick target-text", "end", plot_.target_name);
    }
    draw_legend();
    return svg_ + "</svg>";
  }

 private:
  [[nodiscard]] double px(double x) const { return left + (x - x_.low) / (x_.high - x_.low) * (width - left - right); }
  [[nodiscard]] double py(double y) const {
    return height - bottom - (y - y_.low) / (y_.high - y_.low) * (height - top - bottom);
  }

  void text(double x, double y, const char* style, const char* anchor, const std::string& content) {
    svg_ += "<text class=\"" + std::string(style) + "\" x=\"" + number(x) + "\" y=\"" + number(y) +
            "\" text-anchor=\"" + anchor + "\">" + escaped(content) + "</text>";
  }

  void draw_axes() {
    for (double v = y_.low; v <= y_.high + 0.5 * y_.step; v += y_.step) {
      svg_ += "<line class=\"grid\" x1=\"" + number(left) + "\" x2=\"" + number(width - right) + "\" y1=\"" +
              number(py(v)) + "\" y2=\"" + number(py(v)) + "\"/>";
      text(left - 7, py(v) + 3.5, "tick", "end", tick_text(v, y_.step));
    }
    for (double v = std::ceil(x_.low / x_.step) * x_.step; v <= x_.high; v += x_.step) {
      text(px(v), height - bottom + 15, "tick", "middle", tick_text(v, x_.step));
    }
    text(width - right, height - 8, "tick", "end", plot_.x_label);
    // A long unit begins at the border, so that it is not cut.
    const bool fits = 6.2 * static_cast<double>(plot_.y_label.size()) < left - 7;
    text(fits ? left - 7 : 0, top - 8, "tick", fits ? "end" : "start", plot_.y_label);
  }

  void draw_series(const PlotSeries& series, std::size_t& bar) {
    if (series.mark == Mark::bars) return draw_bars(series, bar++);
    if (series.mark == Mark::line || series.mark == Mark::curve) {
      svg_ += "<polyline class=\"line " + series.style + "\" points=\"";
      for (const auto& [x, y] : series.points) {
        if (std::isfinite(y)) svg_ += number(px(x)) + "," + number(py(y)) + " ";
      }
      svg_ += "\"/>";
    }
    if (series.mark == Mark::curve) return;
    draw_errors(series);
    const double radius = series.points.size() > 120 ? 1.4 : 2.8;
    for (const auto& [x, y] : series.points) {
      if (!std::isfinite(y)) continue;
      svg_ += "<circle class=\"dot " + series.style + "\" cx=\"" + number(px(x)) + "\" cy=\"" + number(py(y)) +
              "\" r=\"" + number(radius) + "\"><title>" + escaped(series.name) + " " + brief(x) + ": " + brief(y) +
              "</title></circle>";
    }
  }

  void draw_errors(const PlotSeries& series) {
    for (std::size_t i = 0; i < series.sigmas.size() && i < series.points.size(); ++i) {
      const auto& [x, y] = series.points[i];
      const double error = error_of(series, i);
      if (!std::isfinite(x) || !std::isfinite(y) || error <= 0) continue;
      svg_ += "<line class=\"line " + series.style + "\" x1=\"" + number(px(x)) + "\" x2=\"" + number(px(x)) +
              "\" y1=\"" + number(py(y - error)) + "\" y2=\"" + number(py(y + error)) + "\"/>";
    }
  }

  void draw_bars(const PlotSeries& series, std::size_t bar) {
    const auto bars = static_cast<double>(std::count_if(plot_.series.begin(), plot_.series.end(),
                                                        [](const PlotSeries& s) { return s.mark == Mark::bars; }));
    const double slot = (px(1) - px(0)) * 0.8, wide = std::min(slot / bars, 26.0);
    for (const auto& [x, y] : series.points) {
      if (!std::isfinite(y)) continue;
      const double x0 = px(x) + (static_cast<double>(bar) - 0.5 * bars) * wide, base = py(std::max(0.0, y_.low));
      svg_ += "<rect class=\"bar " + series.style + "\" x=\"" + number(x0) + "\" y=\"" + number(std::min(py(y), base)) +
              "\" width=\"" + number(std::max(0.8, wide - 1)) + "\" height=\"" + number(std::fabs(base - py(y))) +
              "\"><title>" + escaped(series.name) + " " + brief(x) + ": " + brief(y) + "</title></rect>";
    }
  }

  void draw_legend() {
    if (plot_.series.size() < 2) return;
    double x = left;
    for (const PlotSeries& series : plot_.series) {
      svg_ += "<rect class=\"bar " + series.style + "\" x=\"" + number(x) + "\" y=\"" + number(height - 15) +
              "\" width=\"9\" height=\"9\"/>";
      text(x + 13, height - 7, "tick", "start", series.name);
      x += 28 + 6.2 * static_cast<double>(series.name.size());
    }
  }

  const Plot& plot_;
  std::string svg_;
  Axis x_, y_;
  bool bars_ = false, empty_ = false;
};

}  // namespace

std::string svg_plot(const Plot& plot) {
  return Painter(plot).draw();
}

}  // namespace ilp::host
