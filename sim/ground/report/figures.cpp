#include "sim/ground/report/figures.hpp"

#include <cmath>

#include "sim/host/text_format.hpp"

namespace ilp::report {

std::string px(double value) {
  return host::fixed(value, 1);
}

std::string open_svg(const host::Raster<host::Rgba>& picture, const std::string& label) {
  const std::string w = std::to_string(picture.width), h = std::to_string(picture.height);
  return "<svg viewBox=\"0 0 " + w + " " + h + "\" role=\"img\" aria-label=\"" + label + "\"><image width=\"" + w +
         "\" height=\"" + h + "\" href=\"" + host::data_uri(host::png_bytes(picture)) + "\"/>";
}

std::string segment(const PicturePoint& a, const PicturePoint& b, const char* style) {
  return std::string("<line class=\"") + style + "\" x1=\"" + px(a[0]) + "\" y1=\"" + px(a[1]) + "\" x2=\"" + px(b[0]) +
         "\" y2=\"" + px(b[1]) + "\"/>";
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return "<text class=\"number\" x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\">" + text +
         "</text>";
}

std::string scale_bar(const PlanView& view, const std::string& unit) {
  const double wanted = 0.18 * view.width * view.unit_per_px;
  double length = std::pow(10.0, std::floor(std::log10(wanted)));
  if (wanted >= 5 * length) {
    length *= 5;
  } else if (wanted >= 2 * length) {
    length *= 2;
  }
  const double x0 = 16, y = view.height - 16.0, x1 = x0 + length / view.unit_per_px;
  return segment({x0, y}, {x1, y}, "track dark") + segment({x0, y}, {x1, y}, "track") +
         label(0.5 * (x0 + x1), y - 7, "middle", host::brief(length) + " " + unit);
}

std::string colour_legend(const std::string& title, const host::ValueRange& range, const std::string& unit,
                          std::int32_t width, host::ColourMap colours) {
  // Two legends of a page may have different colours: the name says which.
  const std::string name = colours == host::viridis ? "heights" : "differences";
  std::string svg = "<defs><linearGradient id=\"" + name + "\">";
  for (int i = 0; i <= 10; ++i) {
    const host::Rgb c = colours(i / 10.0);
    svg += "<stop offset=\"" + std::to_string(10 * i) + "%\" stop-color=\"rgb(" + std::to_string(c.r) + "," +
           std::to_string(c.g) + "," + std::to_string(c.b) + ")\"/>";
  }
  const double x = width - 216.0;
  return svg + "</linearGradient></defs>" + label(x + 200, 24, "end", title + ", " + unit) + "<rect x=\"" + px(x) +
         "\" y=\"31\" width=\"200\" height=\"11\" fill=\"url(#" + name + ")\"/>" +
         label(x, 62, "start", host::brief(range.low)) +
         label(x + 100, 62, "middle", host::brief(0.5 * (range.low + range.high))) +
         label(x + 200, 62, "end", host::brief(range.high));
}

std::string direction_arrow(const PlanView& view, double x, double y, const std::string& name) {
  constexpr double length = 24, head = 7;
  const double along = view.cosine * x + view.sine * y, down = -(-view.sine * x + view.cosine * y);
  const PicturePoint foot{view.width - 60.0, view.height - 60.0};
  const auto at = [&](double ahead, double aside) {
    return PicturePoint{foot[0] + ahead * along - aside * down, foot[1] + ahead * down + aside * along};
  };
  const PicturePoint tip = at(length, 0), left = at(length - head, head / 2), right = at(length - head, -head / 2);
  std::string svg;
  for (const char* style : {"track dark", "track"})
    svg += segment(foot, tip, style) + segment(left, tip, style) + segment(right, tip, style);
  const PicturePoint text = at(1.6 * length, 0);
  return svg + label(text[0], text[1] + 4, "middle", name);
}

std::string figure(const std::string& svg, const std::string& caption) {
  return "<figure>" + svg + "</svg><figcaption>" + caption + "</figcaption></figure>\n";
}

}  // namespace ilp::report
