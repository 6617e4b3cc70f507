#include "sim/tools/richness/roc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fsw/base/rng.hpp"

namespace ilp::richness {
namespace {

/// Mann-Whitney on images sorted by score, each counted as often as its world.
double weighted_auc(const std::vector<ScoredImage>& sorted, const std::vector<std::uint32_t>& weight) {
  double plain_below = 0;
  double interesting = 0;
  double won = 0;
  for (std::size_t i = 0; i < sorted.size();) {
    double tied_plain = 0;
    double tied_interesting = 0;
    const double score = sorted[i].score;
    for (; i < sorted.size() && sorted[i].score == score; ++i) {
      (sorted[i].interesting ? tied_interesting : tied_plain) += weight[sorted[i].world];
    }
    won += tied_interesting * (plain_below + 0.5 * tied_plain);
    plain_below += tied_plain;
    interesting += tied_interesting;
  }
  const double pairs = plain_below * interesting;
  return pairs > 0 ? won / pairs : std::numeric_limits<double>::quiet_NaN();
}

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    for (std::size_t k = i; k < end; ++k) rank[order[k]] = 0.5 * static_cast<double>(i + end - 1);
    i = end;
  }
  return rank;
}

}  // namespace

Auc area_under_roc(const std::vector<ScoredImage>& images, int resamples) {
  std::vector<ScoredImage> sorted = images;
  std::sort(sorted.begin(), sorted.end(), [](const ScoredImage& a, const ScoredImage& b) { return a.score < b.score; });
  // Worlds by running number.
  std::vector<std::size_t> worlds;
  for (const ScoredImage& image : sorted) worlds.push_back(image.world);
  std::sort(worlds.begin(), worlds.end());
  worlds.erase(std::unique(worlds.begin(), worlds.end()), worlds.end());
  for (ScoredImage& image : sorted) {
    image.world =
        static_cast<std::size_t>(std::lower_bound(worlds.begin(), worlds.end(), image.world) - worlds.begin());
  }
  Auc auc;
  auc.interesting = static_cast<std::size_t>(
      std::count_if(sorted.begin(), sorted.end(), [](const ScoredImage& image) { return image.interesting; }));
  auc.plain = sorted.size() - auc.interesting;
  auc.value = weighted_auc(sorted, std::vector<std::uint32_t>(worlds.size(), 1));
  auc.low = auc.high = auc.value;
  Rng rng(1, 34);
  std::vector<double> samples;
  for (int k = 0; k < resamples; ++k) {
    std::vector<std::uint32_t> weight(worlds.size(), 0);
    for (std::size_t i = 0; i < worlds.size(); ++i) ++weight[rng.below(static_cast<std::uint32_t>(worlds.size()))];
    const double value = weighted_auc(sorted, weight);
    if (std::isfinite(value)) samples.push_back(value);
  }
  if (samples.empty()) return auc;
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double share) {
    return samples[static_cast<std::size_t>(share * static_cast<double>(samples.size() - 1) + 0.5)];
  };
  auc.low = at(0.025);
  auc.high = at(0.975);
  return auc;
}

std::vector<std::pair<double, double>> roc_curve(const std::vector<ScoredImage>& images) {
  std::vector<ScoredImage> sorted = images;
  std::sort(sorted.begin(), sorted.end(), [](const ScoredImage& a, const ScoredImage& b) { return a.score > b.score; });
  const auto interesting =
      std::count_if(sorted.begin(), sorted.end(), [](const ScoredImage& image) { return image.interesting; });
  const double positives = std::max(1.0, static_cast<double>(interesting));
  const double negatives = std::max(1.0, static_cast<double>(sorted.size()) - static_cast<double>(interesting));
  std::vector<std::pair<double, double>> curve = {{0, 0}};
  double found = 0;
  double wrong = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    (sorted[i].interesting ? found : wrong) += 1;
    const bool tied = i + 1 < sorted.size() && sorted[i + 1].score == sorted[i].score;
    if (!tied) curve.emplace_back(wrong / negatives, found / positives);
  }
  return curve;
}

double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> rank_a = ranks(a);
  const std::vector<double> rank_b = ranks(b);
  const double mean = 0.5 * (static_cast<double>(a.size()) - 1);
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (rank_a[i] - mean) * (rank_b[i] - mean);
    aa += (rank_a[i] - mean) * (rank_a[i] - mean);
    bb += (rank_b[i] - mean) * (rank_b[i] - mean);
  }
  return ab / std::sqrt(aa * bb);
}

}  // namespace ilp::richness
