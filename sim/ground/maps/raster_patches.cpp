#include "sim/ground/maps/raster_patches.hpp"

#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/host/longitude.hpp"

namespace ilp::maps {
namespace {

constexpr std::int32_t node_spacing = 16;  // samples; between them, projections are bilinear to far below a pixel

/// A part of a raster in cells of `factor` pixels.
struct Window {
  std::int32_t x = 0, y = 0, factor = 1;
  host::Raster<float> cells;

  /// Bilinear at a column and row of the file; NaN outside and beside unknown cells.
  [[nodiscard]] float at(double column, double row) const {
    const double u = (column + 0.5 - x) / factor - 0.5, v = (row + 0.5 - y) / factor - 0.5;
    // The border's own pixels are known up to their edges.
    if (!(u >= -0.5 && v >= -0.5 && u <= cells.width - 0.5 && v <= cells.height - 0.5)) return not_known;
    const double cu = std::clamp(u, 0.0, cells.width - 1.0), cv = std::clamp(v, 0.0, cells.height - 1.0);
    const auto i = std::min(static_cast<std::int32_t>(cu), std::max(cells.width - 2, 0));
    const auto j = std::min(static_cast<std::int32_t>(cv), std::max(cells.height - 2, 0));
    const auto a = static_cast<float>(cu - i), b = static_cast<float>(cv - j);
    const std::int32_t k = std::min(i + 1, cells.width - 1), l = std::min(j + 1, cells.height - 1);
    return (1 - b) * ((1 - a) * cells.at(i, j) + a * cells.at(k, j)) +
           b * ((1 - a) * cells.at(i, l) + a * cells.at(k, l));
  }
};

/// Part of the square about a sample, -0.5 to 0.5.
double part_of(std::int32_t i, std::int32_t count) {
  return (i + 0.5) / count - 0.5;
}

}  // namespace

Extent common_part(const Extent& a, const Extent& b) {
  return {std::max(a.west, b.west), std::max(a.south, b.south), std::min(a.east, b.east), std::min(a.north, b.north)};
}

MappedRaster::MappedRaster(std::filesystem::path path, host::RasterBand::Content content)
    : band_(std::move(path), content) {
  static_cast<void>(body());
}

Body MappedRaster::body() const {
  try {
    return body_of(band_.system());
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(band_.path().string() + ": " + error.what());
  }
}

Place MappedRaster::raster_place(double column, double row) const {
  const host::GeoTransform& t = band_.transform();
  return {t[0] + (column + 0.5) * t[1] + (row + 0.5) * t[2], t[3] + (column + 0.5) * t[4] + (row + 0.5) * t[5]};
}

Place MappedRaster::middle() const {
  const std::optional<Place> middle = degrees_from_raster(band_.system(), raster_place(middle_column(), middle_row()));
  if (!middle) throw std::runtime_error(band_.path().string() + ": its middle is not on the body");
  return *middle;
}

void MappedRaster::lay_on(const MapPlane& plane) {
  try {
    from_map_.emplace(plane, band_.system());
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(band_.path().string() + ": " + error.what());
  }
  turn_px_ = columns_of_turn();
  around_ = std::fabs(turn_px_ - band_.columns()) < 0.5;
}

double MappedRaster::columns_of_turn() const {
  const OGRSpatialReference* const system = band_.system();
  const host::GeoTransform& t = band_.transform();
  if (system == nullptr || t[2] != 0 || t[4] != 0) return 0;
  if (system->IsGeographic() != 0) return 360 / std::fabs(t[1]);
  const char* const projection = system->GetAttrValue("PROJECTION");  // null for some that WKT 1 has no word for
  if (system->IsProjected() == 0 || projection == nullptr) return 0;
  const std::initializer_list<std::string_view> cylindrical = {SRS_PT_EQUIRECTANGULAR, SRS_PT_MERCATOR_1SP,
                                                               SRS_PT_MERCATOR_2SP, SRS_PT_CYLINDRICAL_EQUAL_AREA};
  if (std::find(cylindrical.begin(), cylindrical.end(), std::string_view(projection)) == cylindrical.end()) return 0;
  const auto here = degrees_from_raster(system, raster_place(middle_column(), middle_row()));
  const auto beside = degrees_from_raster(system, raster_place(middle_column() + 1, middle_row()));
  return here && beside ? 360 / std::fabs(host::longitude_near(beside->x, here->x) - here->x) : 0;
}

std::optional<Place> MappedRaster::pixel_at(Place map, double near_column) const {
  const std::optional<Place> place = (*from_map_)(map);
  if (!place) return std::nullopt;
  const host::GeoTransform& t = band_.transform();
  const double determinant = t[1] * t[5] - t[2] * t[4], x = place->x - t[0], y = place->y - t[3];
  Place pixel{(x * t[5] - y * t[2]) / determinant - 0.5, (y * t[1] - x * t[4]) / determinant - 0.5};
  if (turn_px_ > 0) pixel.x += turn_px_ * std::round((near_column - pixel.x) / turn_px_);
  return pixel;
}

Extent MappedRaster::extent() const {
  // The border of a raster of half the body or more says little about what it covers: the inside counts too.
  constexpr std::int32_t steps = 64;
  constexpr double far = std::numeric_limits<double>::max();
  Extent extent{far, far, -far, -far};
  for (std::int32_t j = 0; j <= steps; ++j) {
    for (std::int32_t i = 0; i <= steps; ++i) {
      const std::optional<Place> place =
          from_map_->map_from_raster(raster_place(-0.5 + band_.columns() * static_cast<double>(i) / steps,
                                                  -0.5 + band_.rows() * static_cast<double>(j) / steps));
      if (!place) continue;
      extent = {std::min(extent.west, place->x), std::min(extent.south, place->y), std::max(extent.east, place->x),
                std::max(extent.north, place->y)};
    }
  }
  return extent;
}

double MappedRaster::pixel_m() const {
  const double column = middle_column(), row = middle_row();
  const auto at = [&](double c, double r) {
    const std::optional<Place> place = from_map_->map_from_raster(raster_place(c, r));
    if (!place) throw std::runtime_error(band_.path().string() + ": its middle is not on the map's plane");
    return *place;
  };
  const Place here = at(column, row), right = at(column + 1, row), below = at(column, row + 1);
  return std::min(std::hypot(right.x - here.x, right.y - here.y), std::hypot(below.x - here.x, below.y - here.y));
}

/// Pixels of the file at every node_spacing-th sample, and around all of them.
struct MappedRaster::Nodes {
  std::int32_t columns = 0, rows = 0;
  std::vector<std::optional<Place>> pixels;
  Extent around{1e18, 1e18, -1e18, -1e18};  // of columns and rows
  double pixels_per_sample = 0;

  [[nodiscard]] std::optional<Place> at(double i, double j) const {
    const double u = i / node_spacing, v = j / node_spacing;
    const auto c = std::min(static_cast<std::int32_t>(std::max(u, 0.0)), columns - 2);
    const auto r = std::min(static_cast<std::int32_t>(std::max(v, 0.0)), rows - 2);
    const auto node = [&](std::int32_t x, std::int32_t y) -> const std::optional<Place>& {
      return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)];
    };
    const auto &a = node(c, r), &b = node(c + 1, r), &d = node(c, r + 1), &e = node(c + 1, r + 1);
    if (!a || !b || !d || !e) return std::nullopt;
    const double p = u - c, q = v - r;
    return Place{(1 - q) * ((1 - p) * a->x + p * b->x) + q * ((1 - p) * d->x + p * e->x),
                 (1 - q) * ((1 - p) * a->y + p * b->y) + q * ((1 - p) * d->y + p * e->y)};
  }
};

MappedRaster::Nodes MappedRaster::nodes_of(Place first, double spacing_m, std::int32_t columns,
                                           std::int32_t rows) const {
  Nodes nodes;
  nodes.columns = columns / node_spacing + 2;
  nodes.rows = rows / node_spacing + 2;
  double near_column = middle_column(), row_begins_at = near_column;
  for (std::int32_t r = 0; r < nodes.rows; ++r) {
    for (std::int32_t c = 0; c < nodes.columns; ++c) {
      // Columns run on from node to node, also over the ends of longitudes.
      if (c == 0 && r > 0) near_column = row_begins_at;
      const std::optional<Place> pixel =
          pixel_at({first.x + c * node_spacing * spacing_m, first.y - r * node_spacing * spacing_m}, near_column);
      nodes.pixels.push_back(pixel);
      if (!pixel) continue;
      near_column = pixel->x;
      if (c == 0) row_begins_at = pixel->x;
      nodes.around = {std::min(nodes.around.west, pixel->x), std::min(nodes.around.south, pixel->y),
                      std::max(nodes.around.east, pixel->x), std::max(nodes.around.north, pixel->y)};
      const std::optional<Place>& beside = c > 0 ? nodes.pixels[nodes.pixels.size() - 2] : std::nullopt;
      if (beside) {
        // Between such neighbours nothing can be interpolated.
        if (turn_px_ > 0 && std::fabs(pixel->x - beside->x) > turn_px_ / 8) {
          throw std::runtime_error(band_.path().string() +
                                   ": its longitudes meet at a pole in the area of the map; gdalwarp -t_srs with a "
                                   "polar stereographic projection lays it out about the pole");
        }
        nodes.pixels_per_sample =
            std::max(nodes.pixels_per_sample, std::hypot(pixel->x - beside->x, pixel->y - beside->y) / node_spacing);
      }
    }
  }
  return nodes;
}

host::Raster<float> MappedRaster::cells(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                                        std::int32_t factor) {
  if (!around_) return band_.read(x, y, width, height, factor);
  host::Raster<float> all(width, height);
  const std::int32_t turn = band_.columns();
  for (std::int32_t i = 0; i < width;) {
    const std::int32_t first = ((x + i * factor) % turn + turn) % turn;
    const std::int32_t count = std::min(width - i, (turn - first) / factor);
    const host::Raster<float> part = band_.read(first, y, count, height, factor);
    for (std::int32_t j = 0; j < height; ++j) std::copy_n(&part.at(0, j), count, &all.at(i, j));
    i += count;
  }
  return all;
}

host::Raster<float> MappedRaster::means(Place first, double spacing_m, std::int32_t columns, std::int32_t rows,
                                        double box_m) {
  host::Raster<float> result(columns, rows, not_known);
  const Nodes nodes = nodes_of(first, spacing_m, columns, rows);
  const double box = nodes.pixels_per_sample * box_m / spacing_m;  // pixels
  if (!(box > 0)) return result;
  // Of each square, cells of a quarter or less are averaged.
  Window window;
  window.factor =
      std::clamp(static_cast<std::int32_t>(std::min(box / 4, 4096.0)), 1, std::min(band_.columns(), band_.rows()));
  while (around_ && band_.columns() % window.factor != 0) --window.factor;
  const std::int32_t parts = std::clamp(static_cast<std::int32_t>(std::ceil(box / window.factor)), 2, 8);
  const double margin = box + window.factor;
  const auto clipped = [&](double value, std::int32_t most) {
    return static_cast<std::int32_t>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  const auto column = [&](double value) {
    return around_ ? static_cast<std::int32_t>(value) : clipped(value, band_.columns());
  };
  window.x = column(std::floor((nodes.around.west - margin) / window.factor) * window.factor);
  window.y = clipped(std::floor(nodes.around.south - margin), band_.rows()) / window.factor * window.factor;
  const std::int32_t width = (column(nodes.around.east + margin + 1) - window.x) / window.factor;
  const std::int32_t height = (clipped(nodes.around.north + margin + 1, band_.rows()) - window.y) / window.factor;
  if (width <= 0 || height <= 0) return result;
  window.cells = cells(window.x, window.y, width, height, window.factor);
  const double side = box_m / spacing_m;  // of a square, samples
  for (std::int32_t j = 0; j < rows; ++j) {
    for (std::int32_t i = 0; i < columns; ++i) {
      double sum = 0;
      std::int32_t known = 0;
      for (std::int32_t b = 0; b < parts; ++b) {
        for (std::int32_t a = 0; a < parts; ++a) {
          const std::optional<Place> pixel = nodes.at(i + side * part_of(a, parts), j + side * part_of(b, parts));
          const float value = pixel ? window.at(pixel->x, pixel->y) : not_known;
          if (!std::isfinite(value)) continue;
          sum += double{value};
          ++known;
        }
      }
      if (2 * known >= parts * parts) result.at(i, j) = static_cast<float>(sum / known);
    }
  }
  return result;
}

RasterPatches::RasterPatches(MappedRaster& image, MappedRaster& heights, const Extent& area)
    : image_(image), heights_(heights) {
  constexpr std::int32_t side = 512;
  const double spacing_m = std::max(area.east - area.west, area.north - area.south) / side;
  const auto columns = std::max(static_cast<std::int32_t>((area.east - area.west) / spacing_m), 1);
  const auto rows = std::max(static_cast<std::int32_t>((area.north - area.south) / spacing_m), 1);
  const host::Raster<float> coarse =
      image.means({area.west + spacing_m / 2, area.north - spacing_m / 2}, spacing_m, columns, rows, spacing_m);
  double sum = 0;
  std::size_t known = 0;
  for (const float value : coarse.samples) {
    if (!std::isfinite(value)) continue;
    sum += double{value};
    ++known;
  }
  if (known == 0)
    throw std::runtime_error(image.band().path().string() + ": the raster has no data in the area of the map");
  mean_ = sum / static_cast<double>(known);
  if (!(mean_ > 0)) {
    throw std::runtime_error(image.band().path().string() +
                             ": its mean is not above 0; brightness proportional to the light expected");
  }
}

MapPatch RasterPatches::operator()(const MapLayer& layer, const PatchArea& area) {
  const double pixel_m = layer.pixel_m;
  const Place corner{layer.x0_m + area.first_column * pixel_m, layer.y0_m - area.first_row * pixel_m};
  MapPatch patch;
  patch.light =
      image_.means({corner.x + pixel_m / 2, corner.y - pixel_m / 2}, pixel_m, area.columns, area.rows, pixel_m);
  for (float& light : patch.light.samples) light = std::max(light / static_cast<float>(mean_), 0.0F);
  const double spacing_m = map_post_spacing * pixel_m;
  patch.posts = heights_.means(corner, spacing_m, area.columns / map_post_spacing + 1, area.rows / map_post_spacing + 1,
                               spacing_m);
  return patch;
}

}  // namespace ilp::maps
