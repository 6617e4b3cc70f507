#include "sim/ground/ground_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "sim/ground/seams.hpp"
#include "sim/ground/statistics.hpp"

namespace ilp::ground {
namespace {

constexpr float no_height = std::numeric_limits<float>::quiet_NaN();

// A face of neighbouring pixels is a few cells wide; a larger one is an absurd depth, and would cost time without
// bound.
constexpr double max_face_cells = 64;

struct Bounds {
  double x_low = 0, x_high = 0, y_low = 0, y_high = 0;
};

// A handful of wild points must not blow up the grid: beyond the central 99.6 % only a small margin is kept.
void robust_interval(std::vector<double> values, double& low, double& high) {
  const double q_low = percentile(values, 0.002), q_high = percentile(values, 0.998);
  const double margin = 0.03 * (q_high - q_low);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  low = std::max(*least, q_low - margin);
  high = std::min(*most, q_high + margin);
}

Bounds robust_bounds(const std::vector<SurfaceMesh>& pieces) {
  std::vector<double> x, y;
  for (const SurfaceMesh& piece : pieces) {
    for (std::size_t i = 0; i < piece.vertices.size(); i += 7) {
      x.push_back(piece.vertices[i].x);
      y.push_back(piece.vertices[i].y);
    }
  }
  Bounds bounds;
  robust_interval(std::move(x), bounds.x_low, bounds.x_high);
  robust_interval(std::move(y), bounds.y_low, bounds.y_high);
  return bounds;
}

double ground_sampling(const Keyframe& keyframe) {
  std::vector<double> depths;
  for (const float d : keyframe.inverse_depth.samples) {
    if (d > 0) depths.push_back(1.0 / d);
  }
  return median(std::move(depths)) / keyframe.camera.fx;
}

class GridPainter {
 public:
  explicit GridPainter(GroundGrid& grid)
      : grid_(grid),
        height_sum_(grid.height.samples.size()),
        grey_sum_(grid.height.samples.size()),
        sigma_sum_(grid.height.samples.size()),
        weight_(grid.height.samples.size()),
        painted_by_(grid.height.samples.size()) {}

  void paint(const SurfaceMesh& piece, std::uint16_t source) {
    ++piece_;
    source_ = source;
    for (const auto& face : piece.faces) {
      paint_face(piece.vertices[face[0]], piece.vertices[face[1]], piece.vertices[face[2]]);
    }
  }

  // Pixels at the edge of a mask belong to no full triangle; they fill the seams that are still open.
  void paint_points(const std::vector<SurfaceMesh>& pieces, const std::vector<std::uint16_t>& sources) {
    const std::vector<std::uint32_t> faces_only = weight_;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      ++piece_;
      source_ = sources[i];
      for (const SurfaceVertex& v : pieces[i].vertices) {
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
      grid_.ortho.samples[i] = static_cast<std::uint8_t>(std::clamp(grey_sum_[i] / weight_[i] + 0.5, 0.0, 255.0));
    }
    grid_.seam_cells = steps_.size();
    if (steps_.empty()) return;
    grid_.seam_step_median = percentile(steps_, 0.5);
    grid_.seam_step_p95 = percentile(steps_, 0.95);
  }

 private:
  void add(std::size_t cell, double z, double grey, double sigma) {
    const bool again = painted_by_[cell] == piece_;
    if (!again && weight_[cell] != 0) steps_.push_back(std::fabs(z - height_sum_[cell] / weight_[cell]));
    height_sum_[cell] += z;
    grey_sum_[cell] += grey;
    sigma_sum_[cell] += sigma;
    ++weight_[cell];
    if (again) return;
    painted_by_[cell] = piece_;
    if (grid_.source.samples[cell] == 0) grid_.source.samples[cell] = source_;
    ++grid_.count.samples[cell];
  }

  void paint_face(const SurfaceVertex& a, const SurfaceVertex& b, const SurfaceVertex& c) {
    const double ax = grid_.column_of(a.x), ay = grid_.row_of(a.y);
    const double bx = grid_.column_of(b.x), by = grid_.row_of(b.y);
    const double cx = grid_.column_of(c.x), cy = grid_.row_of(c.y);
    const double area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (!(std::fabs(area) > 1e-9)) return;
    const double left = std::max(0.0, std::ceil(std::min({ax, bx, cx})));
    const double right = std::min(grid_.height.width - 1.0, std::floor(std::max({ax, bx, cx})));
    const double top = std::max(0.0, std::ceil(std::min({ay, by, cy})));
    const double bottom = std::min(grid_.height.height - 1.0, std::floor(std::max({ay, by, cy})));
    if (right - left > max_face_cells || bottom - top > max_face_cells) return;
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
  std::vector<std::uint32_t> weight_, painted_by_;
  std::vector<double> steps_;
  std::uint32_t piece_ = 0;
  std::uint16_t source_ = 0;
};

}  // namespace

double GroundGrid::covered_area() const {
  const auto covered = std::count_if(count.samples.begin(), count.samples.end(), [](auto n) { return n > 0; });
  return static_cast<double>(covered) * cell * cell;
}

std::optional<GroundGrid> build_grid(const Flight& flight, const Strip& strip, const GridParams& params,
                                     PixelRays& rays) {
  std::vector<SurfaceMesh> pieces;
  std::vector<std::uint16_t> sources;
  std::vector<double> samplings;
  for (std::size_t i = 0; i < strip.keyframes.size(); ++i) {
    const Keyframe& keyframe = flight.keyframes.at(strip.keyframes[i]);
    if (!has_surface(keyframe)) continue;
    SurfaceMesh piece = keyframe_surface(keyframe, {}, rays);
    if (piece.vertices.empty()) continue;
    samplings.push_back(ground_sampling(keyframe));
    pieces.push_back(std::move(piece));
    sources.push_back(static_cast<std::uint16_t>(i + 1));
  }
  if (pieces.empty()) return std::nullopt;

  const Bounds bounds = robust_bounds(pieces);
  const double width = bounds.x_high - bounds.x_low, height = bounds.y_high - bounds.y_low;
  GroundGrid grid;
  grid.cell = std::max({median(samplings), std::max(width, height) / (params.max_side - 1),
                        std::sqrt(width * height / static_cast<double>(params.max_cells))});
  if (!(grid.cell > 0) || !std::isfinite(grid.cell)) return std::nullopt;
  grid.x0 = bounds.x_low;
  grid.y0 = bounds.y_high;
  const auto columns = static_cast<std::int32_t>(width / grid.cell) + 1;
  const auto rows = static_cast<std::int32_t>(height / grid.cell) + 1;
  grid.height = Raster<float>(columns, rows, no_height);
  grid.sigma = Raster<float>(columns, rows, no_height);
  grid.ortho = Raster<std::uint8_t>(columns, rows);
  grid.count = Raster<std::uint16_t>(columns, rows);
  grid.source = Raster<std::uint16_t>(columns, rows);

  GridPainter painter(grid);
  for (std::size_t i = 0; i < pieces.size(); ++i) painter.paint(pieces[i], sources[i]);
  painter.paint_points(pieces, sources);
  painter.finish();
  close_seams(grid);
  balance_exposure(grid);
  return grid;
}

Plane mean_plane(const GroundGrid& grid) {
  const double middle_x = grid.x0 + 0.5 * grid.cell * grid.height.width;
  const double middle_y = grid.y0 - 0.5 * grid.cell * grid.height.height;
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::int32_t j = 0; j < grid.height.height; ++j) {
    for (std::int32_t i = 0; i < grid.height.width; ++i) {
      const double z = grid.height.at(i, j);
      if (!std::isfinite(z)) continue;
      const Vec3 row(grid.x0 + i * grid.cell - middle_x, grid.y0 - j * grid.cell - middle_y, 1);
      normal += row * row.transpose();
      right += row * z;
    }
  }
  const Vec3 p = normal.ldlt().solve(right);
  if (!p.allFinite()) return {};
  return {p.x(), p.y(), p.z() - p.x() * middle_x - p.y() * middle_y};
}

}  // namespace ilp::ground
