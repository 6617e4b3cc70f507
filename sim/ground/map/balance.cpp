#include "sim/ground/map/balance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace ilp::map {
namespace {

using Patches = std::map<std::int64_t, ShownPatch>;

/// Of the grid's first cell.
struct WorldCell {
  std::int64_t column = 0, row = 0;
};
WorldCell corner_of(const GroundGrid& grid) {
  return {std::llround(grid.x0 / grid.cell), std::llround(-grid.y0 / grid.cell)};
}

GreyLevel level_of(const GreyHistogram& histogram) {
  constexpr double cut = 0.05;
  const auto all = static_cast<double>(histogram.count());
  const double low = cut * all, high = (1 - cut) * all;
  double passed = 0, sum = 0, squares = 0;
  for (const auto& [grey, number] : histogram.entries()) {
    const double before = passed;
    passed += number;
    const double inside = std::max(0.0, std::min(passed, high) - std::max(before, low));
    sum += inside * grey;
    squares += inside * grey * grey;
  }
  const double mean = sum / (high - low);
  return {mean, std::sqrt(std::max(0.0, squares / (high - low) - mean * mean))};
}

/// Contrasts below are mostly noise and rounding.
constexpr double faint_grey = 3;
double trust(double contrast) {
  return 1 / (1 + std::pow(faint_grey / std::max(contrast, 1e-3), 4));
}

/// A value for each patch, which changes linearly over it, from differences at seams and from pulls.
class Network {
 public:
  /// What misses by more than `usual` counts by its size, not by its square (Huber); a pull by more than `usual_pull`.
  /// `share`: of the weight of a patch's seams, for its pull. An error at one fades over 1 / sqrt(2 share) patches.
  /// `ramp_share`: the same for the pull of its ramp to none.
  Network(std::size_t patches, double usual, double usual_pull, double share, double ramp_share)
      : patches_(static_cast<Eigen::Index>(patches)),
        usual_(usual),
        usual_pull_(usual_pull),
        share_(share),
        ramp_share_(ramp_share) {
    wanted_.assign(patches, 0);
  }

  /// A patch, and a place from its middle.
  struct Place {
    Eigen::Index patch = 0;
    double right = 0, down = 0;
  };

  /// value at b - value at a = difference
  void add_difference(const Place& a, const Place& b, double cells, double trusted, double difference) {
    differences_.push_back({a, b, cells, trusted * cells, difference});
  }
  /// The value that a weak pull takes the patch to.
  void pull(std::size_t patch, double wanted) { wanted_[patch] = wanted; }

  /// Value, and its changes to the right and down, of each patch.
  [[nodiscard]] std::vector<std::array<double, 3>> solve() const {
    constexpr int rounds = 8;
    std::vector<double> differences(differences_.size(), 1), pulls(wanted_.size(), 1);
    Eigen::VectorXd solved = once(differences, pulls);
    for (int round = 1; round < rounds; ++round) {
      for (std::size_t i = 0; i < differences.size(); ++i) {
        const Difference& d = differences_[i];
        differences[i] = huber(value(solved, d.b) - value(solved, d.a) - d.value, usual_);
      }
      for (std::size_t i = 0; i < pulls.size(); ++i)
        pulls[i] = huber(solved(3 * static_cast<Eigen::Index>(i)) - wanted_[i], usual_pull_);
      solved = once(differences, pulls);
    }
    std::vector<std::array<double, 3>> values;
    for (Eigen::Index i = 0; i < patches_; ++i) values.push_back({solved(3 * i), solved(3 * i + 1), solved(3 * i + 2)});
    return values;
  }

 private:
  struct Difference {
    Place a, b;
    double cells = 0, weight = 0, value = 0;
  };

  [[nodiscard]] static double huber(double miss, double usual) { return usual / std::max(std::fabs(miss), usual); }
  [[nodiscard]] static double value(const Eigen::VectorXd& solved, const Place& at) {
    return solved(3 * at.patch) + at.right * solved(3 * at.patch + 1) + at.down * solved(3 * at.patch + 2);
  }

  /// With each difference and pull weighed by its share.
  [[nodiscard]] Eigen::VectorXd once(const std::vector<double>& differences, const std::vector<double>& pulls) const {
    constexpr double least = 1e-3;
    std::vector<Eigen::Triplet<double>> normal;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * patches_), tied = Eigen::VectorXd::Zero(patches_);
    for (std::size_t i = 0; i < differences.size(); ++i) {
      const auto& [a, b, cells, all, wanted] = differences_[i];
      const double weight = differences[i] * all;
      const std::array<Eigen::Index, 6> at = {3 * a.patch, 3 * a.patch + 1, 3 * a.patch + 2,
                                              3 * b.patch, 3 * b.patch + 1, 3 * b.patch + 2};
      const std::array<double, 6> row = {-1, -a.right, -a.down, 1, b.right, b.down};
      for (std::size_t k = 0; k < row.size(); ++k) {
        right(at[k]) += weight * row[k] * wanted;
        for (std::size_t n = 0; n < row.size(); ++n) normal.emplace_back(at[k], at[n], weight * row[k] * row[n]);
      }
      tied(a.patch) += cells;
      tied(b.patch) += cells;
    }
    for (Eigen::Index i = 0; i < patches_; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double weight = std::max(pulls[at] * share_ * tied(i), least);
      normal.emplace_back(3 * i, 3 * i, weight);
      right(3 * i) += weight * wanted_[at];
      const double flat = std::max(ramp_share_ * tied(i), least);
      for (const Eigen::Index ramp : {3 * i + 1, 3 * i + 2}) normal.emplace_back(ramp, ramp, flat);
    }
    Eigen::SparseMatrix<double> matrix(3 * patches_, 3 * patches_);
    matrix.setFromTriplets(normal.begin(), normal.end());
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  }

  Eigen::Index patches_;
  double usual_, usual_pull_, share_, ramp_share_;
  std::vector<Difference> differences_;
  std::vector<double> wanted_;
};

/// The patches in the order of their ids, and what the map shows of them.
class PatchTable {
 public:
  explicit PatchTable(const Patches& patches) {
    for (const auto& [id, patch] : patches) {
      places_.emplace(id, static_cast<Eigen::Index>(places_.size()));
      const auto cells = static_cast<double>(std::max<std::uint64_t>(patch.cells, 1));
      cells_.push_back(cells);
      means_.push_back(static_cast<double>(patch.grey) / cells);
      middles_.push_back({std::llround(static_cast<double>(patch.columns) / cells),
                          std::llround(static_cast<double>(patch.rows) / cells)});
      contrasts_.push_back(
          patch.pairs == 0 ? 0 : static_cast<double>(patch.differences) / static_cast<double>(patch.pairs));
    }
  }

  /// Over all cells. In a map of many keyframes in whole `steps`, so that a late keyframe changes what the whole map
  /// has in common once in many times, and else the balance of keyframes near it.
  [[nodiscard]] double in_common(const std::vector<double>& values, double step) const {
    constexpr std::size_t many = 100;
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum += values[i] * cells_[i];
      all += cells_[i];
    }
    return values.size() < many ? sum / all : step * std::round(sum / all / step);
  }

  [[nodiscard]] bool has(std::int64_t id) const { return places_.contains(id); }
  [[nodiscard]] Network::Place place(std::int64_t id, const SeamLevels& m) const {
    const Eigen::Index patch = places_.at(id);
    const auto& [column, row] = middles_[static_cast<std::size_t>(patch)];
    return {patch, (m.column - static_cast<double>(column)) / Balance::ramp_cells,
            (m.row - static_cast<double>(row)) / Balance::ramp_cells};
  }
  [[nodiscard]] const std::map<std::int64_t, Eigen::Index>& places() const { return places_; }
  [[nodiscard]] const std::vector<double>& means() const { return means_; }
  [[nodiscard]] const std::vector<double>& contrasts() const { return contrasts_; }
  [[nodiscard]] const std::vector<std::array<std::int64_t, 2>>& middles() const { return middles_; }
  [[nodiscard]] std::size_t size() const { return cells_.size(); }

 private:
  std::map<std::int64_t, Eigen::Index> places_;
  std::vector<double> cells_, means_, contrasts_;
  std::vector<std::array<std::int64_t, 2>> middles_;
};

std::vector<double> gains_of(const PatchTable& table, const std::vector<SeamLevels>& seams) {
  constexpr double usual_miss = 0.15, usual_pull = 0.3, step = 1.0 / 16, no_ramp = 1e6;
  const double most = std::log(most_gain);
  Network network(table.size(), usual_miss, usual_pull, 1.0 / 4, no_ramp);
  for (const SeamLevels& m : seams) {
    const double trusted = trust(std::min(m.first_level.spread, m.second_level.spread));
    const double least = faint_grey / 4;
    const double ratio = std::log(std::max(m.first_level.spread, least) / std::max(m.second_level.spread, least));
    network.add_difference({table.places().at(m.first)}, {table.places().at(m.second)}, m.cells, trusted,
                           std::clamp(ratio, -most, most));
  }
  std::vector<double> logarithms;
  for (const double contrast : table.contrasts()) logarithms.push_back(std::log(std::max(contrast, faint_grey)));
  const double level = table.in_common(logarithms, step);
  for (std::size_t i = 0; i < table.size(); ++i)
    network.pull(i, trust(table.contrasts()[i]) * std::clamp(level - logarithms[i], -most, most));
  std::vector<double> gains;
  for (const auto& solved : network.solve()) gains.push_back(solved[0]);
  const double middle = table.in_common(gains, step);
  for (double& gain : gains) gain = std::exp(std::clamp(gain - middle, -most, most));
  return gains;
}

}  // namespace

GreyHistogram::GreyHistogram(const std::vector<Entry>& entries) {
  for (const auto& [grey, number] : entries) add(grey, number);
}

void GreyHistogram::add(std::uint8_t grey, std::uint32_t number) {
  const auto at = std::lower_bound(entries_.begin(), entries_.end(), grey,
                                   [](const Entry& entry, std::uint8_t wanted) { return entry.first < wanted; });
  if (at != entries_.end() && at->first == grey) {
    at->second += number;
  } else {
    entries_.insert(at, {grey, number});
  }
}

std::uint64_t GreyHistogram::count() const {
  std::uint64_t all = 0;
  for (const auto& [grey, number] : entries_) all += number;
  return all;
}

void ShownPatch::add(const ShownPatch& other) {
  cells += other.cells;
  grey += other.grey;
  columns += other.columns;
  rows += other.rows;
  pairs += other.pairs;
  differences += other.differences;
}

void add_seam_cell(const ShownCell& a, const ShownCell& b, std::int64_t column, std::int64_t row, Seams& seams) {
  // What is black or white has lost what it was.
  constexpr std::uint8_t darkest = 2, brightest = 253;
  if (std::min(a.grey, b.grey) < darkest || std::max(a.grey, b.grey) > brightest) return;
  const auto& [first, second] =
      std::minmax(a, b, [](const ShownCell& x, const ShownCell& y) { return x.keyframe < y.keyframe; });
  SeamGreys& greys = seams[{first.keyframe, second.keyframe}];
  greys.first.add(first.grey, 1);
  greys.second.add(second.grey, 1);
  greys.columns += column;
  greys.rows += row;
}

void add_seams(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin, Seams& seams) {
  // Cells of closed seams were not measured.
  constexpr std::int32_t farthest = 4;
  const WorldCell corner = corner_of(grid);
  const auto compare = [&](std::int32_t x, std::int32_t y, std::int32_t dx, std::int32_t dy) {
    for (std::int32_t k = 1; k <= farthest; ++k) {
      const std::int32_t u = x + k * dx, v = y + k * dy;
      if (u >= grid.source.width || v >= grid.source.height) return;
      if (grid.count.at(u, v) == 0) continue;
      const std::uint16_t a = grid.source.at(x, y), b = grid.source.at(u, v);
      if (a == b) return;
      add_seam_cell({keyframes[a - 1U], grid.ortho.at(x, y)}, {keyframes[b - 1U], grid.ortho.at(u, v)},
                    corner.column + x, corner.row + y, seams);
      return;
    }
  };
  for (std::int32_t y = margin; y < grid.source.height - margin; ++y) {
    for (std::int32_t x = margin; x < grid.source.width - margin; ++x) {
      if (grid.count.at(x, y) == 0) continue;
      compare(x, y, 1, 0);
      compare(x, y, 0, 1);
    }
  }
}

void add_shown(const GroundGrid& grid, std::int32_t margin, std::vector<ShownPatch>& shown) {
  const WorldCell corner = corner_of(grid);
  for (std::int32_t y = margin; y < grid.source.height - margin; ++y) {
    for (std::int32_t x = margin; x < grid.source.width - margin; ++x) {
      const std::uint16_t source = grid.source.at(x, y);
      if (source == 0) continue;
      ShownPatch& patch = shown[source - 1U];
      const std::uint8_t grey = grid.ortho.at(x, y);
      ++patch.cells;
      patch.grey += grey;
      patch.columns += corner.column + x;
      patch.rows += corner.row + y;
      const auto compare = [&](std::int32_t u, std::int32_t v) {
        if (u >= grid.source.width || v >= grid.source.height || grid.source.at(u, v) != source) return;
        ++patch.pairs;
        patch.differences += static_cast<std::uint64_t>(std::abs(int{grid.ortho.at(u, v)} - int{grey}));
      };
      compare(x + contrast_cells, y);
      compare(x, y + contrast_cells);
    }
  }
}

std::vector<SeamLevels> seam_levels_of(const Seams& seams) {
  constexpr std::uint64_t fewest = 20;
  // Ground looks different from elsewhere, however many cells show it.
  constexpr double many = 1000;
  std::vector<SeamLevels> all;
  for (const auto& [pair, greys] : seams) {
    const std::uint64_t count = greys.first.count();
    if (count < fewest) continue;
    const auto cells = static_cast<double>(count);
    all.push_back({pair.first, pair.second, static_cast<double>(greys.columns) / cells,
                   static_cast<double>(greys.rows) / cells, cells / (1 + cells / many), level_of(greys.first),
                   level_of(greys.second)});
  }
  return all;
}

std::map<std::int64_t, Balance> balance_patches(std::vector<SeamLevels> seams, const Patches& patches) {
  if (patches.empty()) return {};
  const PatchTable table(patches);
  std::erase_if(seams, [&](const SeamLevels& m) { return !table.has(m.first) || !table.has(m.second); });
  // Sums in one order whatever the order of the tiles was.
  std::sort(seams.begin(), seams.end(), [](const SeamLevels& a, const SeamLevels& b) {
    return std::tie(a.first, a.second, a.column, a.row) < std::tie(b.first, b.second, b.column, b.row);
  });
  const std::vector<double> gains = gains_of(table, seams);
  constexpr double usual_miss_grey = 6, usual_pull_grey = 24, step_grey = 8;
  Network network(table.size(), usual_miss_grey, usual_pull_grey, 1.0 / 64, 1.0 / 50);
  for (const SeamLevels& m : seams) {
    const Network::Place a = table.place(m.first, m), b = table.place(m.second, m);
    network.add_difference(a, b, m.cells, 1,
                           gains[static_cast<std::size_t>(a.patch)] * m.first_level.mean -
                               gains[static_cast<std::size_t>(b.patch)] * m.second_level.mean);
  }
  const double level = table.in_common(table.means(), step_grey);
  std::vector<double> scaled;
  for (std::size_t i = 0; i < table.size(); ++i) {
    scaled.push_back(gains[i] * table.means()[i]);
    network.pull(i, level - scaled[i]);
  }
  const std::vector<std::array<double, 3>> solved = network.solve();
  for (std::size_t i = 0; i < table.size(); ++i) scaled[i] += solved[i][0];
  const double middle = table.in_common(scaled, step_grey) - level;
  std::map<std::int64_t, Balance> balance;
  for (const auto& [id, place] : table.places()) {
    const auto at = static_cast<std::size_t>(place);
    const auto& [offset, right, down] = solved[at];
    balance[id] = {gains[at], offset - middle, {right, down}, table.middles()[at]};
  }
  return balance;
}

}  // namespace ilp::map
