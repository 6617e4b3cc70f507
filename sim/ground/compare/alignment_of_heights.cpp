#include "sim/ground/compare/alignment_of_heights.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "sim/ground/compare/difference_statistics.hpp"
#include "sim/host/statistics.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::compare {
namespace {

constexpr std::size_t fewest_samples = 100;
constexpr double tukey = 4.685;
constexpr int most_rounds = 30;
constexpr int coarsest_side = 32;
// A mean slope below this says nothing on a shift.
constexpr double least_slope = 1e-4;

// In the order of the unknowns: shift, turn and growth, the last two as metres at `radius` from `centre`.
using Unknowns = Eigen::Matrix<double, 7, 1>;

struct Residual {
  double height = 0;  ///< map minus other model
  double slope_x = 0, slope_y = 0;
  Vec3 place = Vec3::Zero();
  std::uint8_t half = 0;
};

class Level {
 public:
  Level(const TerrainSamples& samples, HeightModel& other, double max_slope_rad)
      : samples_(samples), other_(other), steepest_(std::tan(max_slope_rad)) {
    for (const TerrainSample& s : samples.cells) centre_ += s.place;
    if (!samples.cells.empty()) centre_ /= static_cast<double>(samples.cells.size());
    for (const TerrainSample& s : samples.cells) {
      radius_ = std::max(radius_, std::hypot(s.place.x() - centre_.x(), s.place.y() - centre_.y()));
    }
  }

  [[nodiscard]] std::vector<Residual> residuals(const host::Similarity3& moved) const {
    std::vector<Residual> all;
    for (const TerrainSample& s : samples_.cells) {
      const PixelScale& scale = samples_.scales[s.scale];
      const Vec3 place = moved * s.place;
      const double dx = place.x() - s.place.x(), dy = place.y() - s.place.y();
      const HeightModel::Sample there =
          other_.at(s.column + scale.column_x * dx + scale.column_y * dy, s.row + scale.row_x * dx + scale.row_y * dy);
      Residual r;
      r.height = place.z() - there.height;
      r.slope_x = there.per_column * scale.column_x + there.per_row * scale.row_x;
      r.slope_y = there.per_column * scale.column_y + there.per_row * scale.row_y;
      r.place = place;
      r.half = s.half;
      if (std::isfinite(r.height) && std::hypot(r.slope_x, r.slope_y) <= steepest_) all.push_back(r);
    }
    return all;
  }

  [[nodiscard]] const Vec3& centre() const { return centre_; }
  [[nodiscard]] double radius() const { return std::max(radius_, 1e-9); }

 private:
  const TerrainSamples& samples_;
  HeightModel& other_;
  double steepest_;
  Vec3 centre_ = Vec3::Zero();
  double radius_ = 0;
};

SpreadOfHeights spread_of(const std::vector<Residual>& residuals) {
  SpreadOfHeights spread;
  spread.cells = residuals.size();
  if (residuals.empty()) return spread;
  std::vector<double> heights;
  for (const Residual& r : residuals) {
    spread.mean += r.height;
    spread.rmse += r.height * r.height;
    heights.push_back(r.height);
  }
  spread.mean /= static_cast<double>(heights.size());
  spread.rmse = std::sqrt(spread.rmse / static_cast<double>(heights.size()));
  spread.median = host::median(heights);
  for (double& height : heights) height = std::fabs(height - spread.median);
  spread.nmad = nmad_factor * host::median(std::move(heights));
  return spread;
}

/// Which unknowns are free.
struct Free {
  bool horizontal = true, similarity = false;
  [[nodiscard]] bool operator()(int k) const {
    if (k < 2) return horizontal;
    return k == 2 || similarity;
  }
};

Unknowns derivatives(const Residual& r, const Vec3& centre, double radius) {
  const Vec3 q = (r.place - centre) / radius;
  Unknowns a;
  a << -r.slope_x, -r.slope_y, 1,  // shift
      q.y() + r.slope_y * q.z(),   // turn about x moves by (0, -qz, qy)
      -q.x() - r.slope_x * q.z(),  // about y by (qz, 0, -qx)
      r.slope_x * q.y() - r.slope_y * q.x(), q.z() - r.slope_x * q.x() - r.slope_y * q.y();
  return a;
}

/// One step of least squares with Tukey's weights; `half` 0 or 1 takes only that half of the chessboard.
Unknowns step_of(const std::vector<Residual>& residuals, const SpreadOfHeights& spread, const Level& level,
                 const Free& free, int half = -1) {
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  Unknowns right = Unknowns::Zero();
  const double bound = tukey * std::max(spread.nmad, 1e-9);
  for (const Residual& r : residuals) {
    if (half >= 0 && r.half != half) continue;
    const double u = (r.height - spread.median) / bound;
    if (std::fabs(u) >= 1) continue;
    const double weight = (1 - u * u) * (1 - u * u);
    const Unknowns a = derivatives(r, level.centre(), level.radius());
    normal += weight * a * a.transpose();
    right -= weight * r.height * a;
  }
  for (int k = 0; k < 7; ++k) {
    if (free(k) && normal(k, k) > 0) continue;
    normal.row(k).setZero();
    normal.col(k).setZero();
    normal(k, k) = 1;
    right(k) = 0;
  }
  // Directions that the ground does not determine stay as they are.
  for (int k = 0; k < 7; ++k) normal(k, k) *= 1 + 1e-9;
  const Unknowns step = normal.ldlt().solve(right);
  return step.allFinite() ? step : Unknowns(Unknowns::Zero());
}

host::Similarity3 moved_by(const host::Similarity3& moved, const Unknowns& step, const Level& level) {
  const Vec3 turn = step.segment<3>(3) / level.radius();
  const double angle = turn.norm();
  host::Similarity3 further;
  further.scale = 1 + step(6) / level.radius();
  if (angle > 0) further.rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  host::Similarity3 sum;
  sum.scale = further.scale * moved.scale;
  sum.rotation = further.rotation * moved.rotation;
  const Vec3 step_to = level.centre() + step.head<3>();
  sum.translation = further.scale * (further.rotation * (moved.translation - level.centre())) + step_to;
  return sum;
}

/// A step over more than two cells goes only that far: the slopes are not those of the far ground.
Unknowns bounded(Unknowns step, double cell) {
  const double far = std::hypot(step(0), step(1));
  if (far > 2 * cell) step.head<2>() *= 2 * cell / far;
  return step;
}

int refine(const Level& level, double cell, const Free& free, host::Similarity3& moved) {
  for (int round = 1; round <= most_rounds; ++round) {
    const std::vector<Residual> residuals = level.residuals(moved);
    if (residuals.size() < fewest_samples) return round;
    const Unknowns step = bounded(step_of(residuals, spread_of(residuals), level, free), cell);
    moved = moved_by(moved, step, level);
    if (step.cwiseAbs().maxCoeff() < 1e-3 * cell) return round;
  }
  return most_rounds;
}

double mean_slope(const std::vector<Residual>& residuals) {
  double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
  for (const Residual& r : residuals) {
    xx += r.slope_x * r.slope_x;
    xy += r.slope_x * r.slope_y;
    yy += r.slope_y * r.slope_y;
    x += r.slope_x;
    y += r.slope_y;
  }
  const auto n = static_cast<double>(residuals.size());
  xx = xx / n - x * x / n / n;
  yy = yy / n - y * y / n / n;
  xy = xy / n - x * y / n / n;
  const double least = 0.5 * (xx + yy) - std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  return std::sqrt(std::max(least, 0.0));
}

class Aligner {
 public:
  Aligner(HeightModel& map, HeightModel& other, const ModelFrames& frames, const AlignmentParams& params)
      : map_(map), other_(other), frames_(frames), params_(params) {}

  HeightAlignment run() {
    const double ratio = cells_of_other();
    const int finest = std::max(1, static_cast<int>(std::lround(1 / ratio)));
    int factor = finest;
    while (2 * factor * coarsest_side <= std::min(map_.columns(), map_.rows())) factor *= 2;
    for (; params_.fit != Fit::none && factor > finest; factor /= 2) {
      const TerrainSamples samples = samples_at(factor, ratio);
      const Level level(samples, other_, params_.max_slope_rad);
      result_.rounds += refine(level, samples.cell, {true, false}, result_.moved);
    }
    finish(samples_at(finest, ratio));
    map_.reduce(1);
    return std::move(result_);
  }

 private:
  /// Pixels of the other model along a pixel of the map.
  double cells_of_other() {
    map_.reduce(std::max(map_.columns(), map_.rows()));
    TerrainSamples few = take_samples(map_, frames_, 1000);
    map_.reduce(1);
    const double side = side_of_pixel(map_) * frames_.common_from_map().scale;
    for (const PixelScale& scale : few.scales) {
      const double pixel = scale.pixel();
      if (std::isfinite(pixel) && pixel > 0) return side / pixel;
    }
    return 1;
  }

  TerrainSamples samples_at(int factor, double ratio) {
    map_.reduce(factor);
    other_.reduce(std::max(1, static_cast<int>(std::lround(ratio * factor))));
    return take_samples(map_, frames_, params_.most_samples);
  }

  void finish(const TerrainSamples& samples) {
    const Level level(samples, other_, params_.max_slope_rad);
    std::vector<Residual> residuals = level.residuals({});
    result_.before = result_.after = spread_of(residuals);
    if (params_.fit == Fit::none) return;
    if (level.residuals(result_.moved).size() < fewest_samples) {
      result_.moved = {};
      if (residuals.size() < fewest_samples) {
        result_.remarks.push_back("The models have " + host::counted(residuals.size(), "sample") +
                                  " in common, too few to align them");
        return;
      }
    }
    Free free{mean_slope(residuals) > least_slope, params_.fit == Fit::similarity};
    align(level, samples.cell, free);
    if (free.horizontal && !(horizontal_residual() < samples.cell && as_good_as_upright(level, samples.cell))) {
      free.horizontal = false;
    }
    if (!free.horizontal) {
      result_.remarks.emplace_back("The relief does not determine a shift in x and y; only heights were aligned");
      result_.moved = {};
      align(level, samples.cell, free);
      result_.residual.head<2>().setZero();
    }
    result_.aligned = true;
    result_.horizontal = free.horizontal;
    result_.shift = result_.moved * level.centre() - level.centre();
    const Eigen::AngleAxisd turn(result_.moved.rotation);
    result_.turn_rad = turn.angle() * turn.axis();
  }

  void align(const Level& level, double cell, const Free& free) {
    result_.rounds += refine(level, cell, free, result_.moved);
    const std::vector<Residual> residuals = level.residuals(result_.moved);
    result_.after = spread_of(residuals);
    const Unknowns one = step_of(residuals, result_.after, level, free, 0);
    const Unknowns two = step_of(residuals, result_.after, level, free, 1);
    result_.residual = (one - two).head<3>();
  }

  [[nodiscard]] double horizontal_residual() const { return result_.residual.head<2>().norm(); }

  /// Whether x and y have not led away: the surfaces are as near to each other as heights alone bring them. Where the
  /// shift is a small part of a cell, both are equal but for chance.
  [[nodiscard]] bool as_good_as_upright(const Level& level, double cell) const {
    host::Similarity3 upright;
    refine(level, cell, {false, params_.fit == Fit::similarity}, upright);
    return result_.after.nmad <= spread_of(level.residuals(upright)).nmad * 1.05;
  }

  HeightModel &map_, &other_;
  const ModelFrames& frames_;
  const AlignmentParams& params_;
  HeightAlignment result_;
};

}  // namespace

HeightAlignment align_heights(HeightModel& map, HeightModel& other, const ModelFrames& frames,
                              const AlignmentParams& params) {
  return Aligner(map, other, frames, params).run();
}

}  // namespace ilp::compare
