// The errors of a flight's merged heights against the truth.
#include <algorithm>
#include <cmath>

#include "sim/ground/report/figures.hpp"
#include "sim/ground/report/map_figures.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

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

}  // namespace

std::string figure_of_height_errors(const ScoreFile& score) {
  const CoveredBox box = covered_box(score.height_error);
  if (box.right < box.left) return "";
  const host::Raster<float> map = reduced(score.height_error, box);
  host::ValueRange range = host::display_range(map);
  // Zero lies in the middle, so that colour distinguishes too high from too low.
  range.high = std::max(std::fabs(range.low), std::fabs(range.high));
  range.low = -range.high;
  return figure(open_svg(host::colour_mapped(map, range, host::diverging), "height errors"),
                "Errors of the merged heights on the truth's grid, strip laid onto the truth: too low " +
                    colour_bar(range) + " too high, in the truth's unit. Blank: not mapped.");
}

}  // namespace ilp::report
