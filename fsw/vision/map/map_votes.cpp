#include "fsw/vision/map/map_votes.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/map/patch_search.hpp"

namespace ilp {
namespace {

constexpr std::int32_t least_share_percent = 90;  // of a patch that the sheet shows
constexpr std::int32_t offsets = 4;               // of the grid of patches that are tried along each axis
constexpr std::int32_t agree_px = 1;              // a vote: 3 x 3 lags
constexpr double quarter_agrees_px = 1.6;
constexpr std::int32_t other_px = 4;  // from the peak: another shift
constexpr std::int32_t least_patches = 6;
constexpr std::int32_t least_quarters = 3;
constexpr double rival_factor = 2.5;  // votes over those that agree on any other shift: ground that repeats
constexpr double places = 9;          // lags of a vote

/// Whether nine tenths of a patch are known, by sums over the sheet.
struct Coverage {
  ImageView<const std::int32_t> sums;
  std::int32_t side;

  [[nodiscard]] bool holds(std::int32_t column, std::int32_t row) const {
    const std::int32_t known = sums.at(column + side, row + side) - sums.at(column, row + side) -
                               sums.at(column + side, row) + sums.at(column, row);
    return 100 * known >= least_share_percent * side * side;
  }
};

/// Calls `visit(column, row)` for the patches of a grid.
template <typename Visit>
void for_patches(const Coverage& coverage, std::int32_t width, std::int32_t height, std::int32_t offset_x,
                 std::int32_t offset_y, Visit visit) {
  for (std::int32_t row = offset_y; row + coverage.side <= height; row += coverage.side) {
    for (std::int32_t column = offset_x; column + coverage.side <= width; column += coverage.side) {
      if (coverage.holds(column, row)) visit(column, row);
    }
  }
}

bool near(const MapPatch& patch, std::int32_t column, std::int32_t row, std::int32_t within) {
  return std::abs(patch.best_column - column) <= within && std::abs(patch.best_row - row) <= within;
}

}  // namespace

double vertex(double before, double middle, double after) {
  const double bend = before + after - 2 * middle;
  if (!(bend < 0)) return 0;
  return std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
}

std::int32_t choose_patches(const MapChannels<max_map_sheet_side>& sheet, std::int32_t side,
                            MapRegistrationWorkspace& workspace) {
  const std::int32_t stride = sheet.width + 1;
  std::int32_t* const sums = workspace.sums.data();
  std::fill_n(sums, stride, 0);
  for (std::int32_t row = 0; row < sheet.height; ++row) {
    std::int32_t* const below = sums + static_cast<std::ptrdiff_t>(row + 1) * stride;
    below[0] = 0;
    for (std::int32_t column = 0; column < sheet.width; ++column) {
      const std::int32_t known = sheet.value[sheet.at(column, row)] != unknown_value ? 1 : 0;
      below[column + 1] = below[column] + below[column + 1 - stride] - below[column - stride] + known;
    }
  }
  const Coverage coverage{{sums, stride, sheet.height + 1}, side};
  std::int32_t best = 0, best_x = 0, best_y = 0;
  for (std::int32_t oy = 0; oy < offsets; ++oy) {
    for (std::int32_t ox = 0; ox < offsets; ++ox) {
      std::int32_t count = 0;
      const std::int32_t x = ox * side / offsets, y = oy * side / offsets;
      for_patches(coverage, sheet.width, sheet.height, x, y, [&](std::int32_t, std::int32_t) { ++count; });
      if (count <= best) continue;
      best = count;
      best_x = x;
      best_y = y;
    }
  }
  const std::int32_t most = static_cast<std::int32_t>(max_map_patches), taken = std::min(best, most);
  std::int32_t seen = 0, chosen = 0;
  for_patches(coverage, sheet.width, sheet.height, best_x, best_y, [&](std::int32_t column, std::int32_t row) {
    const bool take = chosen < taken && seen * taken >= chosen * best;
    ++seen;
    if (!take) return;
    MapPatch& patch = workspace.patches[static_cast<std::size_t>(chosen++)];
    patch = {};
    patch.column = static_cast<std::int16_t>(column);
    patch.row = static_cast<std::int16_t>(row);
    patch.quarter = static_cast<std::int16_t>((column / side + 2 * (row / side % 2)) % 4);
  });
  return chosen;
}

void VoteSurfaces::clear() {
  std::fill_n(workspace_.sums.begin(), 4 * lags_ * lags_, 0);
}

std::int32_t VoteSurfaces::add(MapPatch& patch) {
  std::int32_t* sum = workspace_.sums.data() + static_cast<std::ptrdiff_t>(patch.quarter) * lags_ * lags_;
  const auto row_of = [&](std::int32_t row) {
    return workspace_.surface.data() + static_cast<std::ptrdiff_t>(row) * map_lag_stride;
  };
  std::int32_t known = 0, best = unknown_score;
  for (std::int32_t row = 0; row < lags_; ++row) {
    const std::int32_t* const scores = row_of(row);
    for (std::int32_t column = 0; column < lags_; ++column) {
      if (scores[column] == unknown_score) continue;
      ++known;
      if (scores[column] <= best) continue;
      best = scores[column];
      patch.best_column = static_cast<std::int16_t>(column);
      patch.best_row = static_cast<std::int16_t>(row);
    }
  }
  // Even ground of the map agrees with nothing, everywhere alike.
  if (2 * known < lags_ * lags_ || best <= 0) return 0;
  for (std::int32_t row = 0; row < lags_; ++row) {
    const std::int32_t* const scores = row_of(row);
    for (std::int32_t column = 0; column < lags_; ++column, ++sum) {
      if (scores[column] != unknown_score) *sum += scores[column];
    }
  }
  return known;
}

std::int64_t VoteSurfaces::at(std::uint32_t which, std::int32_t column, std::int32_t row) const {
  const auto lags = static_cast<std::size_t>(lags_);
  std::int64_t sum = 0;
  for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
    if ((which >> quarter & 1U) == 0) continue;
    sum += workspace_.sums[(quarter * lags + static_cast<std::size_t>(row)) * lags + static_cast<std::size_t>(column)];
  }
  return sum;
}

VoteSurfaces::Peak VoteSurfaces::peak(std::uint32_t which) const {
  Peak peak;
  std::int64_t best = at(which, 0, 0);
  for (std::int32_t row = 0; row < lags_; ++row) {
    for (std::int32_t column = 0; column < lags_; ++column) {
      const std::int64_t sum = at(which, column, row);
      if (sum <= best) continue;
      best = sum;
      peak.column = column;
      peak.row = row;
    }
  }
  peak.fine_column = peak.column;
  peak.fine_row = peak.row;
  if (peak.column < 1 || peak.row < 1 || peak.column + 1 >= lags_ || peak.row + 1 >= lags_) return peak;
  const auto value = [&](std::int32_t dx, std::int32_t dy) {
    return static_cast<double>(at(which, peak.column + dx, peak.row + dy));
  };
  peak.fine_column += vertex(value(-1, 0), value(0, 0), value(1, 0));
  peak.fine_row += vertex(value(0, -1), value(0, 0), value(0, 1));
  return peak;
}

double vote_evidence(std::int32_t votes, std::int32_t patches, double lags) {
  const double p = std::min(places / lags, 0.5);
  if (votes <= 0 || patches <= 0) return det_log(p);
  // ln of the chance of exactly `votes`, then the sum of the further ones relative to it.
  double log_chance = votes * det_log(p) + (patches - votes) * det_log(1 - p);
  for (std::int32_t k = 1; k <= votes; ++k) {
    log_chance += det_log(static_cast<double>(patches - votes + k) / static_cast<double>(k));
  }
  double term = 1, sum = 1;
  for (std::int32_t k = votes + 1; k <= patches; ++k) {
    term *= static_cast<double>(patches - k + 1) / static_cast<double>(k) * p / (1 - p);
    sum += term;
  }
  return -log_chance - det_log(sum) + det_log(p);
}

MapVote count_votes(std::span<const MapPatch> patches, const VoteSurfaces& surfaces, std::int32_t side, double lags,
                    double min_evidence) {
  MapVote vote;
  std::uint32_t quarters_with = 0;
  for (const MapPatch& patch : patches) {
    if (!patch.used) continue;
    ++vote.patches;
    quarters_with |= 1U << static_cast<std::uint32_t>(patch.quarter);
  }
  if (vote.patches < least_patches) return vote;
  const VoteSurfaces::Peak peak = surfaces.peak(VoteSurfaces::all);
  vote.column = peak.column;
  vote.row = peak.row;
  vote.fine_column = peak.fine_column;
  vote.fine_row = peak.fine_row;
  for (const MapPatch& patch : patches) {
    if (!patch.used) continue;
    vote.votes += near(patch, peak.column, peak.row, agree_px) ? 1 : 0;
    if (near(patch, peak.column, peak.row, other_px)) continue;
    std::int32_t rivals = 0;
    for (const MapPatch& other : patches) {
      const bool counts = other.used && !near(other, peak.column, peak.row, other_px);
      rivals += counts && near(other, patch.best_column, patch.best_row, agree_px) ? 1 : 0;
    }
    vote.rivals = std::max(vote.rivals, rivals);
  }
  for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
    if ((quarters_with >> quarter & 1U) == 0) continue;
    const VoteSurfaces::Peak own = surfaces.peak(1U << quarter);
    vote.quarters += std::fabs(own.fine_column - peak.fine_column) <= quarter_agrees_px &&
                             std::fabs(own.fine_row - peak.fine_row) <= quarter_agrees_px
                         ? 1
                         : 0;
  }
  vote.evidence = vote_evidence(vote.votes, vote.patches, lags);
  const std::int32_t last = side - 1 - map_edge_px;
  if (vote.evidence < min_evidence || vote.quarters < least_quarters) {
    vote.verdict = MapVerdict::no_agreement;
  } else if (vote.votes <= rival_factor * vote.rivals) {
    vote.verdict = MapVerdict::ambiguous;
  } else if (peak.column < map_edge_px || peak.row < map_edge_px || peak.column > last || peak.row > last) {
    vote.verdict = MapVerdict::at_edge;
  } else {
    vote.verdict = MapVerdict::fixed;
  }
  return vote;
}

}  // namespace ilp
