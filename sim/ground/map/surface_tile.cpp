#include "sim/ground/map/surface_tile.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/ground/intake/keyframe_rasters.hpp"

namespace ilp::map {
using nlohmann::json;
namespace {

constexpr auto margin = static_cast<std::size_t>(tile_margin_cells);

// A face of neighbouring pixels is a few cells wide; a larger one is an absurd depth, and would cost time without
// bound.
constexpr double max_face_cells = 64;

constexpr double classes_per_octave = 32;
constexpr double smallest_step = 1e-6;  // of a cell: no step

std::int32_t step_class(double cells) {
  return static_cast<std::int32_t>(std::floor(classes_per_octave * std::log2(std::max(cells, smallest_step))));
}

/// A cell that two patches show.
struct SharedCell {
  std::size_t cell = 0;
  std::uint16_t first = 0, second = 0;  ///< sources
  std::uint8_t first_grey = 0, second_grey = 0;
};

/// Heights are the mean of all patches; the image is that of the first patch alone, because a mean of images is blurred
/// and has a border wherever a patch ends.
class TilePainter {
 public:
  explicit TilePainter(GroundGrid& grid)
      : grid_(grid),
        height_sum_(grid.height.samples.size()),
        grey_sum_(grid.height.samples.size()),
        sigma_sum_(grid.height.samples.size()),
        weight_(grid.height.samples.size()),
        grey_weight_(grid.height.samples.size()),
        painted_by_(grid.height.samples.size()) {}

  void paint(const SurfaceMesh& patch) {
    ++patch_;
    ++source_;
    for (const auto& face : patch.faces) {
      paint_face(patch.vertices[face[0]], patch.vertices[face[1]], patch.vertices[face[2]]);
    }
  }

  // Pixels at the edge of a mask belong to no full triangle; they fill the seams that are still open.
  void paint_points(const std::vector<TilePatch>& patches) {
    const std::vector<std::uint32_t> faces_only = weight_;
    source_ = 0;
    for (const TilePatch& patch : patches) {
      ++patch_;
      ++source_;
      for (const SurfaceVertex& v : patch.surface->vertices) {
        const double column = std::floor(grid_.column_of(v.x) + 0.5), row = std::floor(grid_.row_of(v.y) + 0.5);
        if (!(column >= 0) || !(row >= 0) || column >= grid_.height.width || row >= grid_.height.height) continue;
        const std::size_t cell = grid_.height.index(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
        if (faces_only[cell] == 0) add(cell, v.z, v.grey, v.sigma);
      }
    }
  }

  void finish() {
    for (std::size_t i = 0; i < weight_.size(); ++i) {
      if (weight_[i] == 0) continue;
      grid_.height.samples[i] = static_cast<float>(height_sum_[i] / weight_[i]);
      // Neighbours in one image err alike: their mean is no better than one of them.
      if (sigma_sum_[i] > 0) grid_.sigma.samples[i] = static_cast<float>(sigma_sum_[i] / weight_[i]);
      grid_.ortho.samples[i] = grey_at(i);
    }
  }

  std::uint64_t seam_cells = 0;
  std::map<std::int32_t, std::uint32_t> steps;
  std::vector<SharedCell> shared_cells;

 private:
  static std::uint8_t to_grey(double grey) { return static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0)); }
  [[nodiscard]] std::uint8_t grey_at(std::size_t cell) const { return to_grey(grey_sum_[cell] / grey_weight_[cell]); }

  [[nodiscard]] bool in_core(std::size_t cell) const {
    const auto width = static_cast<std::size_t>(grid_.height.width);
    const std::size_t x = cell % width, y = cell / width;
    return x >= margin && x < margin + tile_side_cells && y >= margin && y < margin + tile_side_cells;
  }

  void add(std::size_t cell, double z, double grey, double sigma) {
    const bool again = painted_by_[cell] == patch_;
    if (!again && weight_[cell] != 0 && in_core(cell)) {
      ++seam_cells;
      ++steps[step_class(std::fabs(z - height_sum_[cell] / weight_[cell]) / grid_.cell)];
    }
    height_sum_[cell] += z;
    sigma_sum_[cell] += sigma;
    ++weight_[cell];
    std::uint16_t& source = grid_.source.samples[cell];
    if (source == 0) source = source_;
    if (source == source_) {
      grey_sum_[cell] += grey;
      ++grey_weight_[cell];
    }
    if (again) return;
    painted_by_[cell] = patch_;
    ++grid_.count.samples[cell];
    if (source != source_ && in_core(cell))
      shared_cells.push_back({cell, source, source_, grey_at(cell), to_grey(grey)});
  }

  void paint_face(const SurfaceVertex& a, const SurfaceVertex& b, const SurfaceVertex& c) {
    const double ax = grid_.column_of(a.x), ay = grid_.row_of(a.y);
    const double bx = grid_.column_of(b.x), by = grid_.row_of(b.y);
    const double cx = grid_.column_of(c.x), cy = grid_.row_of(c.y);
    const double least_x = std::min({ax, bx, cx}), most_x = std::max({ax, bx, cx});
    const double least_y = std::min({ay, by, cy}), most_y = std::max({ay, by, cy});
    const double left = std::max(0.0, std::ceil(least_x));
    const double right = std::min(grid_.height.width - 1.0, std::floor(most_x));
    const double top = std::max(0.0, std::ceil(least_y));
    const double bottom = std::min(grid_.height.height - 1.0, std::floor(most_y));
    if (right < left || bottom < top || most_x - least_x > max_face_cells || most_y - least_y > max_face_cells) return;
    const double area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (!(std::fabs(area) > 1e-9)) return;
    constexpr double edge = -1e-9;
    for (double y = top; y <= bottom; ++y) {
      for (double x = left; x <= right; ++x) {
        const double u = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area;
        const double v = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area;
        if (u < edge || v < edge || u + v > 1 - edge) continue;
        add(grid_.height.index(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)),
            a.z + u * (b.z - a.z) + v * (c.z - a.z), a.grey + u * (b.grey - a.grey) + v * (c.grey - a.grey),
            (a.sigma + b.sigma + c.sigma) / 3.0);
      }
    }
  }

  GroundGrid& grid_;
  std::vector<double> height_sum_, grey_sum_, sigma_sum_;
  std::vector<std::uint32_t> weight_, grey_weight_, painted_by_;
  std::uint32_t patch_ = 0;
  std::uint16_t source_ = 0;
};

template <typename T>
host::Raster<T> core_of(const host::Raster<T>& raster) {
  return host::part_of(raster, tile_margin_cells, tile_margin_cells, tile_side_cells, tile_side_cells);
}

MapTile core_of(const MapTile& cells) {
  MapTile core;
  core.height = core_of(cells.height);
  core.sigma = core_of(cells.sigma);
  core.ortho = core_of(cells.ortho);
  core.count = core_of(cells.count);
  core.source = core_of(cells.source);
  core.laid.height = core_of(cells.laid.height);
  core.laid.grey = core_of(cells.laid.grey);
  core.laid.source = core_of(cells.laid.source);
  return core;
}

void summarise_cells(const MapTile& cells, TileSummary& summary) {
  summary.left = summary.top = tile_side_cells;
  for (std::int32_t y = 0; y < tile_side_cells; ++y) {
    for (std::int32_t x = 0; x < tile_side_cells; ++x) {
      const std::size_t i = cells.height.index(x, y);
      summary.measured += cells.count.samples[i] > 0 ? 1U : 0U;
      if (cells.source.samples[i] == 0) continue;
      summary.left = std::min(summary.left, x);
      summary.right = std::max(summary.right, x);
      summary.top = std::min(summary.top, y);
      summary.bottom = std::max(summary.bottom, y);
    }
  }
}

template <typename T>
void append(const host::Raster<T>& raster, std::vector<std::uint8_t>& bytes) {
  const auto* first = reinterpret_cast<const std::uint8_t*>(raster.samples.data());
  bytes.insert(bytes.end(), first, first + raster.samples.size() * sizeof(T));
}

template <typename T>
void take(host::Raster<T>& raster, std::int32_t side, const std::uint8_t*& at) {
  raster = host::Raster<T>(side, side);
  std::memcpy(raster.samples.data(), at, raster.samples.size() * sizeof(T));
  at += raster.samples.size() * sizeof(T);
}

constexpr std::size_t cell_bytes = 4 + 4 + 1 + 2 + 2 + 4 + 1 + 2;

// Of heights whose error is not stated.
constexpr double usual_sigma_cells = 0.5;
// Images are sharp up to their borders: the step of the brightness is faded, and one cell on each side is smoothed.
constexpr BlendParams grey_blend{.fade_cells = 12, .band_cells = 1, .band_smoothness = 1, .band_shape = 1};

std::size_t bytes_of(const SurfaceMesh& mesh) {
  return mesh.vertices.capacity() * sizeof(mesh.vertices[0]) + mesh.faces.capacity() * sizeof(mesh.faces[0]);
}

json list_of(const Seams& seams) {
  json list = json::array();
  for (const auto& [pair, greys] : seams)
    list.push_back({pair, greys.first.entries(), greys.second.entries(), greys.columns, greys.rows});
  return list;
}

Seams seams_from(const json& stored) {
  Seams seams;
  for (const json& entry : stored) {
    seams[entry.at(0).get<std::pair<std::int64_t, std::int64_t>>()] = {
        GreyHistogram(entry.at(1).get<std::vector<GreyHistogram::Entry>>()),
        GreyHistogram(entry.at(2).get<std::vector<GreyHistogram::Entry>>()), entry.at(3), entry.at(4)};
  }
  return seams;
}

json list_of(const std::vector<ShownPatch>& shown) {
  json list = json::array();
  for (const ShownPatch& patch : shown)
    list.push_back({patch.cells, patch.grey, patch.columns, patch.rows, patch.pairs, patch.differences});
  return list;
}

std::vector<ShownPatch> shown_from(const json& stored) {
  std::vector<ShownPatch> shown;
  for (const json& entry : stored)
    shown.push_back({entry.at(0), entry.at(1), entry.at(2), entry.at(3), entry.at(4), entry.at(5)});
  return shown;
}

/// Column or row of the world of the first cell of a painted tile.
std::int64_t first_cell(std::int32_t place) {
  return std::int64_t{place} * tile_side_cells - tile_margin_cells;
}

/// Laid ground of the patches, where `area` has none that was measured.
LaidGround paint_laid(const GroundGrid& area, const std::vector<TilePatch>& patches) {
  GroundGrid laid(area.x0, area.y0, area.cell, area.height.width, area.height.height);
  TilePainter painter(laid);
  static const SurfaceMesh none;
  for (const TilePatch& patch : patches) painter.paint(patch.laid ? *patch.laid : none);
  painter.finish();
  for (std::size_t i = 0; i < laid.source.samples.size(); ++i) {
    if (area.source.samples[i] == 0 && laid.source.samples[i] != 0) continue;
    laid.height.samples[i] = std::numeric_limits<float>::quiet_NaN();
    laid.ortho.samples[i] = 0;
    laid.source.samples[i] = 0;
  }
  return {std::move(laid.height), std::move(laid.ortho), std::move(laid.source)};
}

}  // namespace

double seam_step(std::int32_t step_class) {
  return std::exp2((step_class + 0.5) / classes_per_octave);
}

SurfaceTile paint_tile(const intake::TilePlace& place, double cell, const std::vector<TilePatch>& patches) {
  constexpr std::int32_t side = painted_side_cells;
  GroundGrid area(static_cast<double>(first_cell(place.column)) * cell,
                  -static_cast<double>(first_cell(place.row)) * cell, cell, side, side);
  TilePainter painter(area);
  for (const TilePatch& patch : patches) painter.paint(*patch.surface);
  painter.paint_points(patches);
  painter.finish();
  close_seams(area);

  SurfaceTile tile;
  TileSummary& summary = tile.summary;
  for (const TilePatch& patch : patches) summary.keyframes.push_back(patch.keyframe_id);
  summary.seam_cells = painter.seam_cells;
  summary.steps = std::move(painter.steps);
  add_seams(area, summary.keyframes, tile_margin_cells, summary.seams);
  const std::int64_t left = first_cell(place.column), top = first_cell(place.row);
  for (const SharedCell& m : painter.shared_cells) {
    constexpr auto side_cells = static_cast<std::size_t>(side);
    add_seam_cell({summary.keyframes[m.first - 1U], m.first_grey}, {summary.keyframes[m.second - 1U], m.second_grey},
                  left + static_cast<std::int64_t>(m.cell % side_cells),
                  top + static_cast<std::int64_t>(m.cell / side_cells), summary.seams);
  }
  summary.shown.assign(summary.keyframes.size(), {});
  add_shown(area, tile_margin_cells, summary.shown);
  LaidGround laid = paint_laid(area, patches);
  tile.cells = {0,
                0,
                std::move(area.height),
                std::move(area.sigma),
                std::move(area.ortho),
                std::move(area.count),
                std::move(area.source),
                std::move(laid)};
  summarise_cells(core_of(tile.cells), summary);
  return tile;
}

std::vector<std::uint8_t> bytes_of(const TileSummary& s) {
  const json stored = {{"keyframes", s.keyframes},
                       {"shown", list_of(s.shown)},
                       {"measured", s.measured},
                       {"seam_cells", s.seam_cells},
                       {"steps", s.steps},
                       {"seams", list_of(s.seams)},
                       {"box", {s.left, s.top, s.right, s.bottom}}};
  return json::to_cbor(stored);
}

std::optional<TileSummary> summary_from(std::span<const std::uint8_t> bytes) {
  try {
    const json stored = json::from_cbor(bytes.begin(), bytes.end());
    TileSummary s;
    stored.at("keyframes").get_to(s.keyframes);
    s.shown = shown_from(stored.at("shown"));
    stored.at("measured").get_to(s.measured);
    stored.at("seam_cells").get_to(s.seam_cells);
    stored.at("steps").get_to(s.steps);
    s.seams = seams_from(stored.at("seams"));
    const json& box = stored.at("box");
    box.at(0).get_to(s.left);
    box.at(1).get_to(s.top);
    box.at(2).get_to(s.right);
    box.at(3).get_to(s.bottom);
    const bool inside = s.left >= 0 && s.top >= 0 && s.right < tile_side_cells && s.bottom < tile_side_cells;
    if (s.shown.size() != s.keyframes.size() || (!s.empty() && !inside)) return std::nullopt;
    return s;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

std::vector<std::uint8_t> bytes_of(const MapTile& cells) {
  std::vector<std::uint8_t> plain;
  plain.reserve(cells.height.samples.size() * cell_bytes);
  append(cells.height, plain);
  append(cells.sigma, plain);
  append(cells.ortho, plain);
  append(cells.count, plain);
  append(cells.source, plain);
  append(cells.laid.height, plain);
  append(cells.laid.grey, plain);
  append(cells.laid.source, plain);
  uLongf size = compressBound(plain.size());
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, plain.data(), plain.size(), Z_BEST_SPEED) != Z_OK) throw std::bad_alloc();
  packed.resize(size);
  return packed;
}

std::optional<MapTile> cells_from(std::span<const std::uint8_t> bytes, std::int32_t side) {
  const auto cells_per_side = static_cast<std::size_t>(side);
  std::vector<std::uint8_t> plain(cells_per_side * cells_per_side * cell_bytes);
  uLongf size = plain.size();
  if (uncompress(plain.data(), &size, bytes.data(), bytes.size()) != Z_OK || size != plain.size()) return std::nullopt;
  MapTile cells;
  const std::uint8_t* at = plain.data();
  take(cells.height, side, at);
  take(cells.sigma, side, at);
  take(cells.ortho, side, at);
  take(cells.count, side, at);
  take(cells.source, side, at);
  take(cells.laid.height, side, at);
  take(cells.laid.grey, side, at);
  take(cells.laid.source, side, at);
  return cells;
}

MapTile finish_tile(const intake::TilePlace& place, const MapTile& painted, const std::vector<Balance>& balance,
                    double cell) {
  MapTile tile = painted;
  host::Raster<float> grey(tile.ortho.width, tile.ortho.height);
  host::Raster<std::uint16_t> shown = tile.source;
  for (std::size_t i = 0; i < grey.samples.size(); ++i) {
    std::uint16_t& s = shown.samples[i];
    const bool measured = s != 0;
    if (!measured) s = tile.laid.source.samples[i];
    if (s == 0) continue;
    const auto column = first_cell(place.column) + static_cast<std::int64_t>(i % static_cast<std::size_t>(grey.width));
    const auto row = first_cell(place.row) + static_cast<std::int64_t>(i / static_cast<std::size_t>(grey.width));
    grey.samples[i] = static_cast<float>(
        balance[s - 1U].of(measured ? tile.ortho.samples[i] : tile.laid.grey.samples[i], column, row));
  }
  // Heights bend within their estimated errors: without any, they are taken as they are.
  const bool stated = std::any_of(tile.sigma.samples.begin(), tile.sigma.samples.end(),
                                  [](float sigma) { return std::isfinite(sigma) && sigma > 0; });
  if (stated) blend_patches(tile.source, tile.sigma, static_cast<float>(usual_sigma_cells * cell), {}, tile.height);
  blend_patches(shown, {}, 1, grey_blend, grey);
  for (std::size_t i = 0; i < grey.samples.size(); ++i) {
    if (shown.samples[i] == 0) continue;
    const auto one = static_cast<std::uint8_t>(std::clamp(grey.samples[i] + 0.5F, 0.0F, 255.0F));
    if (tile.source.samples[i] != 0) {
      tile.ortho.samples[i] = one;
    } else {
      tile.laid.grey.samples[i] = std::max<std::uint8_t>(one, 1);
    }
  }
  return core_of(tile);
}

std::optional<TilePatch> PatchCache::held(std::int64_t keyframe_id) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const TilePatch& entry) { return entry.keyframe_id == keyframe_id; });
  if (found == entries_.end()) return std::nullopt;
  entries_.splice(entries_.begin(), entries_, found);
  return *found;
}

TilePatch PatchCache::patch(std::int64_t keyframe_id, PixelRays& rays) {
  {
    const std::lock_guard lock(mutex_);
    if (auto patch = held(keyframe_id)) return *patch;
  }
  const intake::Keyframe& keyframe = flight_.keyframes.at(keyframe_id);
  const intake::DecodedProducts decoded = intake::decode_products(keyframe);
  const TilePatch made{keyframe_id,
                       std::make_shared<const SurfaceMesh>(keyframe_surface(keyframe, decoded.rasters, {}, rays)),
                       std::make_shared<const SurfaceMesh>(laid_surface(keyframe, decoded.rasters, rays))};
  const auto size = [](const TilePatch& patch) { return bytes_of(*patch.surface) + bytes_of(*patch.laid); };
  const std::lock_guard lock(mutex_);
  // Another thread may have been faster.
  if (auto theirs = held(keyframe_id)) return *theirs;
  entries_.push_front(made);
  held_bytes_ += size(made);
  while (held_bytes_ > budget_ && entries_.size() > 1) {
    held_bytes_ -= size(entries_.back());
    entries_.pop_back();
  }
  return made;
}

}  // namespace ilp::map
