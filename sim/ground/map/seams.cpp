#include "sim/ground/map/seams.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace ilp::map {
namespace {

constexpr std::int32_t max_gap_cells = 2;
constexpr double ratio_steps = 512;
// Heights on both sides of a seam differ by no more than a wall of 76 degrees would (MergeParams::max_depth_jump).
constexpr double max_slope = 4;
constexpr std::array<std::array<std::int32_t, 2>, 4> directions = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

struct Side {
  std::int32_t x = 0, y = 0, cells = 0;  ///< distance
};

/// The nearest covered cell that way, at most max_gap_cells off; cells 0: none.
Side covered_towards(const host::Raster<std::uint16_t>& source, std::int32_t x, std::int32_t y, std::int32_t dx,
                     std::int32_t dy) {
  for (std::int32_t k = 1; k <= max_gap_cells; ++k) {
    const std::int32_t u = x + k * dx, v = y + k * dy;
    if (u < 0 || v < 0 || u >= source.width || v >= source.height) return {};
    if (source.at(u, v) != 0) return {u, v, k};
  }
  return {};
}

struct Crossing {
  Side a, b;
};

/// `use(x, y, crossing)` for every empty cell between covered ones of two keyframes, by the shortest way across.
template <typename Use>
void for_each_seam_cell(const host::Raster<std::uint16_t>& source, Use use) {
  for (std::int32_t y = 0; y < source.height; ++y) {
    for (std::int32_t x = 0; x < source.width; ++x) {
      if (source.at(x, y) != 0) continue;
      Crossing best;
      for (const auto& [dx, dy] : directions) {
        const Crossing crossing{covered_towards(source, x, y, dx, dy), covered_towards(source, x, y, -dx, -dy)};
        if (crossing.a.cells == 0 || crossing.b.cells == 0) continue;
        if (source.at(crossing.a.x, crossing.a.y) == source.at(crossing.b.x, crossing.b.y)) continue;
        const bool shorter = crossing.a.cells + crossing.b.cells < best.a.cells + best.b.cells;
        if (best.a.cells == 0 || shorter) best = crossing;
      }
      if (best.a.cells != 0) use(x, y, best);
    }
  }
}

double median_of(const StepHistogram& samples, std::uint64_t count) {
  std::uint64_t passed = 0;
  for (const auto& [step, number] : samples) {
    passed += number;
    if (2 * passed >= count) return step / ratio_steps;
  }
  return 0;
}

}  // namespace

StepHistogram::StepHistogram(std::vector<Entry> entries) {
  for (const auto& [step, number] : entries) add(step, number);
}

void StepHistogram::add(std::int32_t step, std::uint32_t number) {
  const auto at = std::lower_bound(entries_.begin(), entries_.end(), step,
                                   [](const Entry& entry, std::int32_t wanted) { return entry.first < wanted; });
  if (at != entries_.end() && at->first == step) {
    at->second += number;
  } else {
    entries_.insert(at, {step, number});
  }
}

void StepHistogram::add(const StepHistogram& other) {
  for (const auto& [step, number] : other) add(step, number);
}

void close_seams(GroundGrid& grid) {
  const host::Raster<std::uint16_t> source = grid.source;
  for_each_seam_cell(source, [&](std::int32_t x, std::int32_t y, const Crossing& crossing) {
    const auto [a, b] = crossing;
    const double za = grid.height.at(a.x, a.y), zb = grid.height.at(b.x, b.y);
    const double way = std::hypot(a.x - b.x, a.y - b.y) * grid.cell;
    if (!(std::fabs(za - zb) <= max_slope * way)) return;
    const double share = static_cast<double>(a.cells) / (a.cells + b.cells);
    grid.height.at(x, y) = static_cast<float>(za + share * (zb - za));
    const double grey = grid.ortho.at(a.x, a.y) + share * (grid.ortho.at(b.x, b.y) - grid.ortho.at(a.x, a.y));
    grid.ortho.at(x, y) = static_cast<std::uint8_t>(grey + 0.5);
    grid.source.at(x, y) = source.at(share < 0.5 ? a.x : b.x, share < 0.5 ? a.y : b.y);
  });
}

void add_seam_ratios(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin,
                     SeamRatios& ratios) {
  constexpr double darkest = 8;  // below, rounding to whole grey levels is most of the ratio
  const auto add = [&](std::int32_t xa, std::int32_t ya, std::int32_t xb, std::int32_t yb) {
    const std::uint16_t a = grid.source.at(xa, ya), b = grid.source.at(xb, yb);
    const double grey_a = grid.ortho.at(xa, ya), grey_b = grid.ortho.at(xb, yb);
    if (a == b || a == 0 || b == 0 || grey_a < darkest || grey_b < darkest) return;
    const std::int64_t id_a = keyframes[a - 1U], id_b = keyframes[b - 1U];
    const auto steps = static_cast<std::int32_t>(std::lround(ratio_steps * std::log(grey_a / grey_b)));
    if (id_a < id_b) {
      ratios[{id_a, id_b}].add(steps, 1);
    } else {
      ratios[{id_b, id_a}].add(-steps, 1);
    }
  };
  // Pieces that touch have no empty cell between them: any two cells a short way apart will do.
  constexpr std::int32_t apart = max_gap_cells + 1;
  for (std::int32_t y = margin; y < grid.source.height - margin; ++y) {
    for (std::int32_t x = margin; x < grid.source.width - margin; ++x) {
      if (x + apart < grid.source.width) add(x, y, x + apart, y);
      if (y + apart < grid.source.height) add(x, y, x, y + apart);
    }
  }
}

namespace {

using Pieces = std::map<std::int64_t, ShownPiece>;

/// Normal equations for the logarithms of the gains, by the place of a keyframe in `pieces`.
class GainEquations {
 public:
  explicit GainEquations(const Pieces& pieces) {
    for (const auto& [id, piece] : pieces) {
      const auto cells = static_cast<double>(std::max<std::uint64_t>(piece.cells, 1));
      places_.emplace(id, static_cast<Eigen::Index>(places_.size()));
      cells_.push_back(cells);
      levels_.push_back(std::log(std::max(static_cast<double>(piece.grey) / cells, 1.0)));
    }
    size_ = static_cast<Eigen::Index>(places_.size());
    right_ = Eigen::VectorXd::Zero(size_);
    tied_ = Eigen::VectorXd::Zero(size_);
  }

  /// gain_b - gain_a = log(grey_a / grey_b)
  void add_seam(const std::pair<std::int64_t, std::int64_t>& pair, const StepHistogram& samples) {
    constexpr std::uint64_t fewest = 20;
    std::uint64_t count = 0;
    for (const auto& [step, number] : samples) count += number;
    const auto first = places_.find(pair.first), second = places_.find(pair.second);
    if (count < fewest || first == places_.end() || second == places_.end()) return;
    const Eigen::Index a = first->second, b = second->second;
    const auto weight = static_cast<double>(count);
    const double ratio = median_of(samples, count);
    normal_.emplace_back(a, a, weight);
    normal_.emplace_back(b, b, weight);
    normal_.emplace_back(a, b, -weight);
    normal_.emplace_back(b, a, -weight);
    right_(a) -= weight * ratio;
    right_(b) += weight * ratio;
    tied_(a) += weight;
    tied_(b) += weight;
  }

  /// Of the mean brightness to that of the map. An error at a seam fades over 1 / sqrt(2 share) keyframes of a strip.
  void add_pull() {
    constexpr double share = 1.0 / 16, least = 1e-3;
    const double level = in_common(mean(levels_));
    for (Eigen::Index i = 0; i < size_; ++i) {
      const double weight = std::max(share * tied_(i), least);
      normal_.emplace_back(i, i, weight);
      right_(i) += weight * (level - levels_[static_cast<std::size_t>(i)]);
    }
  }

  [[nodiscard]] std::map<std::int64_t, double> gains() const {
    Eigen::SparseMatrix<double> matrix(size_, size_);
    matrix.setFromTriplets(normal_.begin(), normal_.end());
    const Eigen::VectorXd solved = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right_);
    const double middle = in_common(mean({solved.begin(), solved.end()}));
    std::map<std::int64_t, double> gains;
    for (const auto& [id, place] : places_) gains[id] = std::exp(solved(place) - middle);
    return gains;
  }

 private:
  /// In a map of many keyframes in steps of a sixteenth, so that a late keyframe changes what the whole map has in
  /// common once in many times, and else the gains of keyframes near it.
  [[nodiscard]] double in_common(double logarithm) const {
    constexpr Eigen::Index many = 100;
    constexpr double steps = 16;
    return size_ < many ? logarithm : std::round(steps * logarithm) / steps;
  }

  /// Over all cells.
  [[nodiscard]] double mean(const std::vector<double>& values) const {
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum += values[i] * cells_[i];
      all += cells_[i];
    }
    return sum / all;
  }

  std::map<std::int64_t, Eigen::Index> places_;
  std::vector<double> cells_, levels_;  ///< levels: logarithms of the mean brightness
  Eigen::Index size_ = 0;
  std::vector<Eigen::Triplet<double>> normal_;
  Eigen::VectorXd right_, tied_;  ///< tied: weights of a keyframe's seams
};

}  // namespace

std::map<std::int64_t, double> balance_exposures(const SeamRatios& ratios, const Pieces& pieces) {
  if (pieces.empty()) return {};
  GainEquations equations(pieces);
  for (const auto& [pair, samples] : ratios) equations.add_seam(pair, samples);
  equations.add_pull();
  return equations.gains();
}

}  // namespace ilp::map
