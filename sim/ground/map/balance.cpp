#include "sim/ground/map/balance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace ilp::map {
namespace {

using Patches = std::map<std::int64_t, ShownPatch>;

/// Mean and spread without a twentieth at either end, where clouds, shadows and glints are.
struct Level {
  double mean = 0, spread = 0;
};

Level level_of(const GreyHistogram& histogram) {
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

/// One value for each piece, from differences at seams and from pulls.
class Network {
 public:
  /// What misses by more than `usual` counts by its size, not by its square (Huber); a pull by more than `usual_pull`.
  /// `share`: of the weight of a piece's seams, for its pull. An error at a seam fades over 1 / sqrt(2 share) pieces.
  Network(std::size_t patches, double usual, double usual_pull, double share)
      : size_(static_cast<Eigen::Index>(patches)), usual_(usual), usual_pull_(usual_pull), share_(share) {
    wanted_.assign(patches, 0);
  }

  /// value_b - value_a = difference
  void add_difference(Eigen::Index a, Eigen::Index b, double cells, double trusted, double difference) {
    differences_.push_back({a, b, cells, trusted * cells, difference});
  }
  /// The value that a weak pull takes the piece to.
  void pull(std::size_t patch, double wanted) { wanted_[patch] = wanted; }

  [[nodiscard]] std::vector<double> solve() const {
    constexpr int rounds = 8;
    std::vector<double> seams(differences_.size(), 1), pulls(wanted_.size(), 1);
    Eigen::VectorXd solved = once(seams, pulls);
    for (int round = 1; round < rounds; ++round) {
      for (std::size_t i = 0; i < seams.size(); ++i) {
        const Difference& d = differences_[i];
        seams[i] = huber(solved(d.b) - solved(d.a) - d.value, usual_);
      }
      for (std::size_t i = 0; i < pulls.size(); ++i)
        pulls[i] = huber(solved(static_cast<Eigen::Index>(i)) - wanted_[i], usual_pull_);
      solved = once(seams, pulls);
    }
    return {solved.begin(), solved.end()};
  }

 private:
  struct Difference {
    Eigen::Index a = 0, b = 0;
    double cells = 0, weight = 0, value = 0;
  };

  [[nodiscard]] static double huber(double miss, double usual) { return usual / std::max(std::fabs(miss), usual); }

  /// With each difference and pull weighed by its share.
  [[nodiscard]] Eigen::VectorXd once(const std::vector<double>& seams, const std::vector<double>& pulls) const {
    constexpr double least = 1e-3;
    std::vector<Eigen::Triplet<double>> normal;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size_), tied = right;
    for (std::size_t i = 0; i < seams.size(); ++i) {
      const auto& [a, b, cells, all, value] = differences_[i];
      const double weight = seams[i] * all;
      normal.emplace_back(a, a, weight);
      normal.emplace_back(b, b, weight);
      normal.emplace_back(a, b, -weight);
      normal.emplace_back(b, a, -weight);
      right(a) -= weight * value;
      right(b) += weight * value;
      tied(a) += cells;
      tied(b) += cells;
    }
    for (Eigen::Index i = 0; i < size_; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double weight = std::max(pulls[at] * share_ * tied(i), least);
      normal.emplace_back(i, i, weight);
      right(i) += weight * wanted_[at];
    }
    Eigen::SparseMatrix<double> matrix(size_, size_);
    matrix.setFromTriplets(normal.begin(), normal.end());
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  }

  Eigen::Index size_;
  double usual_, usual_pull_, share_;
  std::vector<Difference> differences_;
  std::vector<double> wanted_;
};

/// The pieces in the order of their ids, and what the map shows of them.
class PatchTable {
 public:
  explicit PatchTable(const Patches& patches) {
    for (const auto& [id, patch] : patches) {
      places_.emplace(id, static_cast<Eigen::Index>(places_.size()));
      const auto cells = static_cast<double>(std::max<std::uint64_t>(patch.cells, 1));
      cells_.push_back(cells);
      means_.push_back(static_cast<double>(patch.grey) / cells);
      contrasts_.push_back(
          patch.pairs == 0 ? 0 : static_cast<double>(patch.differences) / static_cast<double>(patch.pairs));
    }
  }

  struct Meeting {
    Eigen::Index a = 0, b = 0;
    double cells = 0;  ///< less than they are, where there are many
    Level first, second;
  };
  [[nodiscard]] std::vector<Meeting> meetings(const Seams& seams) const {
    constexpr std::uint64_t fewest = 20;
    // Ground looks different from elsewhere, however many cells show it.
    constexpr double many = 1000;
    std::vector<Meeting> all;
    for (const auto& [pair, greys] : seams) {
      const std::uint64_t count = greys.first.count();
      const auto first = places_.find(pair.first), second = places_.find(pair.second);
      if (count < fewest || first == places_.end() || second == places_.end()) continue;
      const double counted = static_cast<double>(count) / (1 + static_cast<double>(count) / many);
      all.push_back({first->second, second->second, counted, level_of(greys.first), level_of(greys.second)});
    }
    return all;
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

  [[nodiscard]] const std::map<std::int64_t, Eigen::Index>& places() const { return places_; }
  [[nodiscard]] const std::vector<double>& means() const { return means_; }
  [[nodiscard]] const std::vector<double>& contrasts() const { return contrasts_; }
  [[nodiscard]] std::size_t size() const { return cells_.size(); }

 private:
  std::map<std::int64_t, Eigen::Index> places_;
  std::vector<double> cells_, means_, contrasts_;
};

std::vector<double> gains_of(const PatchTable& table, const std::vector<PatchTable::Meeting>& meetings) {
  constexpr double usual_miss = 0.15, usual_pull = 0.3, step = 1.0 / 16;
  const double most = std::log(most_gain);
  Network network(table.size(), usual_miss, usual_pull, 1.0 / 4);
  for (const PatchTable::Meeting& m : meetings) {
    const double trusted = trust(std::min(m.first.spread, m.second.spread));
    const double least = faint_grey / 4;
    const double ratio = std::log(std::max(m.first.spread, least) / std::max(m.second.spread, least));
    network.add_difference(m.a, m.b, m.cells, trusted, std::clamp(ratio, -most, most));
  }
  std::vector<double> logarithms;
  for (const double contrast : table.contrasts()) logarithms.push_back(std::log(std::max(contrast, faint_grey)));
  const double level = table.in_common(logarithms, step);
  for (std::size_t i = 0; i < table.size(); ++i)
    network.pull(i, trust(table.contrasts()[i]) * std::clamp(level - logarithms[i], -most, most));
  std::vector<double> gains = network.solve();
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

void GreyHistogram::add(const GreyHistogram& other) {
  for (const auto& [grey, number] : other.entries_) add(grey, number);
}

std::uint64_t GreyHistogram::count() const {
  std::uint64_t all = 0;
  for (const auto& [grey, number] : entries_) all += number;
  return all;
}

void ShownPatch::add(const ShownPatch& other) {
  cells += other.cells;
  grey += other.grey;
  pairs += other.pairs;
  differences += other.differences;
}

void add_meeting(std::int64_t id_a, std::uint8_t grey_a, std::int64_t id_b, std::uint8_t grey_b, Seams& seams) {
  // What is black or white has lost what it was.
  constexpr std::uint8_t darkest = 2, brightest = 253;
  if (std::min(grey_a, grey_b) < darkest || std::max(grey_a, grey_b) > brightest) return;
  SeamGreys& greys = seams[std::minmax(id_a, id_b)];
  (id_a < id_b ? greys.first : greys.second).add(grey_a, 1);
  (id_a < id_b ? greys.second : greys.first).add(grey_b, 1);
}

void add_seams(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin, Seams& seams) {
  // Cells of closed seams were not measured.
  constexpr std::int32_t farthest = 4;
  const auto compare = [&](std::int32_t x, std::int32_t y, std::int32_t dx, std::int32_t dy) {
    for (std::int32_t k = 1; k <= farthest; ++k) {
      const std::int32_t u = x + k * dx, v = y + k * dy;
      if (u >= grid.source.width || v >= grid.source.height) return;
      if (grid.count.at(u, v) == 0) continue;
      const std::uint16_t a = grid.source.at(x, y), b = grid.source.at(u, v);
      if (a == b) return;
      add_meeting(keyframes[a - 1U], grid.ortho.at(x, y), keyframes[b - 1U], grid.ortho.at(u, v), seams);
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
  for (std::int32_t y = margin; y < grid.source.height - margin; ++y) {
    for (std::int32_t x = margin; x < grid.source.width - margin; ++x) {
      const std::uint16_t source = grid.source.at(x, y);
      if (source == 0) continue;
      ShownPatch& patch = shown[source - 1U];
      const std::uint8_t grey = grid.ortho.at(x, y);
      ++patch.cells;
      patch.grey += grey;
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

std::map<std::int64_t, Balance> balance_patches(const Seams& seams, const Patches& patches) {
  if (patches.empty()) return {};
  const PatchTable table(patches);
  const std::vector<PatchTable::Meeting> meetings = table.meetings(seams);
  const std::vector<double> gains = gains_of(table, meetings);
  constexpr double usual_miss_grey = 6, usual_pull_grey = 24, step_grey = 8;
  Network network(table.size(), usual_miss_grey, usual_pull_grey, 1.0 / 16);
  for (const PatchTable::Meeting& m : meetings) {
    const auto a = static_cast<std::size_t>(m.a), b = static_cast<std::size_t>(m.b);
    network.add_difference(m.a, m.b, m.cells, 1, gains[a] * m.first.mean - gains[b] * m.second.mean);
  }
  const double level = table.in_common(table.means(), step_grey);
  std::vector<double> scaled;
  for (std::size_t i = 0; i < table.size(); ++i) {
    scaled.push_back(gains[i] * table.means()[i]);
    network.pull(i, level - scaled[i]);
  }
  const std::vector<double> offsets = network.solve();
  for (std::size_t i = 0; i < table.size(); ++i) scaled[i] += offsets[i];
  const double middle = table.in_common(scaled, step_grey) - level;
  std::map<std::int64_t, Balance> balance;
  for (const auto& [id, place] : table.places()) {
    const auto at = static_cast<std::size_t>(place);
    balance[id] = {gains[at], offsets[at] - middle};
  }
  return balance;
}

}  // namespace ilp::map
