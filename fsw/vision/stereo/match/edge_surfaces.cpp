#include "fsw/vision/stereo/match/edge_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/match/flagged_columns.hpp"
#include "fsw/vision/stereo/match/patch_difference.hpp"

namespace ilp {
namespace {

constexpr std::int16_t none = std::numeric_limits<std::int16_t>::min();
static_assert(quarters_per_px * limits::max_rectified_width < std::numeric_limits<std::int16_t>::max());

// Mean difference of counterparts that may still be the same.
constexpr float most_alike = 14 * quarters_per_px;
// Sigmas of noise by which another surface must be better. Windows are drawn to the nearer surface, so that a pixel
// that has the farther one has it for a reason.
constexpr double margin_noises = 2, nearer_margin_noises = 6;
// A pixel without a disparity whose closest neighbours vary by less is blank, as liquid and sky are.
constexpr double texture_noises = 2;
// More surfaces around one pixel are chance matches.
constexpr std::int32_t most_surfaces = 6;
constexpr std::int32_t same_disparity = quarters_per_px / 2;
// What a pixel's surroundings say of it weighs as much as so many grey levels of its counterparts.
constexpr float surroundings_grey = 11;
// Another disparity that a window found weighs as much, unless its counterparts differ by so much more.
constexpr float window_grey = 11;
// Doubt above which the pixel may as well belong to another surface.
constexpr float most_suspect_grey = 10;
// The error on the right surface, and that of a suspect choice, by the distance to the farthest other surface.
constexpr float right_surface_sigma_px = 0.4F, suspect_share = 0.6F, most_sigma_px = 6;
// Where less of a tile is matched, chance may have made its edges.
constexpr std::int32_t least_matched_percent = 55;
constexpr std::int32_t unknown_brightness = std::numeric_limits<std::int32_t>::max();

std::int32_t rounded_quarters(float disparity_px) {
  return static_cast<std::int32_t>(std::floor(disparity_px * quarters_per_px + 0.5F));
}

/// By row number, also of those above and below the map. Column x is at edge_reach + x.
EdgeWorkspace::QuarterRow& row_of(EdgeWorkspace& w, std::int32_t y) {
  return w.rows[static_cast<std::size_t>((y + edge_rows) % edge_rows)];
}

void take_row(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t y,
              EdgeWorkspace::QuarterRow& row) {
  if (y < 0 || y >= sigma_px.height) {
    row.fill(none);
    return;
  }
  const float* __restrict d = disparity_px.row(y);
  const float* __restrict s = sigma_px.row(y);
  std::int16_t* __restrict out = row.data() + edge_reach;
  std::fill_n(row.begin(), edge_reach, none);
  std::fill_n(out + sigma_px.width, edge_reach, none);
  // Made positive before truncation to a whole number, which rounds without a call of floor.
  constexpr float lift = limits::max_rectified_width;
  for (std::int32_t x = 0; x < sigma_px.width; ++x) {
    // NOLINTNEXTLINE(bugprone-incorrect-roundings)
    const auto lifted = static_cast<std::int32_t>((d[x] + lift) * quarters_per_px + 0.5F);
    const std::int32_t quarter_px = lifted - quarters_per_px * limits::max_rectified_width;
    out[x] = s[x] > 0 ? static_cast<std::int16_t>(quarter_px) : none;
  }
}

struct TileSums {
  std::int32_t visible = 0, matched = 0, brighter = 0;
};

/// Over every fourth pixel of every fourth row.
TileSums tile_sums(const NccRows& rows, std::int32_t x_begin, std::int32_t y_begin, ImageView<const float> disparity_px,
                   ImageView<const float> sigma_px) {
  constexpr std::int32_t every = 4;
  TileSums sums;
  for (std::int32_t y = y_begin; y < std::min(y_begin + search_tile, sigma_px.height); y += every) {
    for (std::int32_t x = x_begin; x < std::min(x_begin + search_tile, sigma_px.width); x += every) {
      sums.visible += rows.left_valid.at(x, y) != 0 ? 1 : 0;
      const std::int32_t target = x - whole_px(rounded_quarters(disparity_px.at(x, y)));
      if (!(sigma_px.at(x, y) > 0) || target < 0 || target >= rows.right.width) continue;
      sums.brighter += rows.left.at(x, y) - rows.right.at(target, y);
      ++sums.matched;
    }
  }
  return sums;
}

/// What counterparts differ by because the images are not equally bright, in the tiles of the band that begins at `y`.
void measure_brightness(const NccRows& rows, std::int32_t y, ImageView<const float> disparity_px,
                        ImageView<const float> sigma_px, EdgeWorkspace& w) {
  for (std::int32_t x = 0; x < sigma_px.width; x += search_tile) {
    const TileSums sums = tile_sums(rows, x, y, disparity_px, sigma_px);
    const bool known = sums.matched > 0 && 100 * sums.matched >= least_matched_percent * sums.visible;
    w.brightness[static_cast<std::size_t>(x / search_tile)] =
        known ? quarters_per_px * sums.brighter / sums.matched : unknown_brightness;
  }
}

/// Extends the ranges by the pixels of a row that are `away` columns to the left, straight and to the right.
void extend_ranges(const EdgeWorkspace::QuarterRow& row, std::int32_t away, std::int32_t width, EdgeWorkspace& w) {
  const std::int16_t* __restrict before = row.data() + edge_reach - away;
  const std::int16_t* __restrict at = row.data() + edge_reach;
  const std::int16_t* __restrict after = row.data() + edge_reach + away;
  std::int16_t* __restrict lowest = w.lowest.data();
  std::int16_t* __restrict highest = w.highest.data();
  // One less wraps around where there is no disparity, which makes it the highest of all.
  const auto lowered = [](std::int16_t quarter_px) { return static_cast<std::int16_t>(quarter_px - 1); };
  for (std::int32_t x = 0; x < width; ++x) {
    const std::int16_t low = std::min(std::min(lowered(before[x]), lowered(at[x])), lowered(after[x]));
    const std::int16_t high = std::max(std::max(before[x], at[x]), after[x]);
    lowest[x] = std::min(lowest[x], low);
    highest[x] = std::max(highest[x], high);
  }
}

/// The pixel and those at half the reach and at the whole one, in eight directions. `lowest` is lowered by one.
void find_ranges(std::int32_t y, std::int32_t width, EdgeWorkspace& w) {
  std::fill_n(w.lowest.begin(), width, std::numeric_limits<std::int16_t>::max());
  std::fill_n(w.highest.begin(), width, none);
  for (std::int32_t away = edge_reach / 2; away <= edge_reach; away += edge_reach / 2) {
    for (std::int32_t v = y - away; v <= y + away; v += away) extend_ranges(row_of(w, v), away, width, w);
  }
}

/// Whether the surroundings differ from the pixel by more than a step, or from each other if it has no disparity. 0 or
/// 1 without branches.
[[gnu::always_inline]] inline int is_at_edge(std::int32_t lowest, std::int32_t highest, std::int32_t own,
                                             std::int32_t step) {
  const int without = static_cast<int>(own == none);
  const int differ = static_cast<int>(highest - lowest > step);
  const int away = static_cast<int>(highest - own > step) | static_cast<int>(own - lowest > step);
  return (without & differ) | (~without & away);
}

/// The surfaces around a pixel that are not its own.
struct Candidates {
  std::array<std::int16_t, most_surfaces> quarter_px{};
  std::array<float, most_surfaces> difference{};
  std::int32_t count = 0;

  /// False where there are too many.
  bool take(std::int16_t disparity) {
    for (std::int32_t k = 0; k < count; ++k) {
      if (std::abs(quarter_px[static_cast<std::size_t>(k)] - disparity) < same_disparity) return true;
    }
    if (count == most_surfaces) return false;
    quarter_px[static_cast<std::size_t>(count++)] = disparity;
    return true;
  }
};

Candidates candidates_of(std::int32_t x, std::int32_t y, std::int16_t own, std::int32_t step, EdgeWorkspace& w) {
  Candidates found;
  for (std::int32_t away = edge_reach / 2; away <= edge_reach; away += edge_reach / 2) {
    for (std::int32_t v = y - away; v <= y + away; v += away) {
      const std::int16_t* row = row_of(w, v).data() + edge_reach;
      for (std::int32_t u = x - away; u <= x + away; u += away) {
        const std::int16_t beside = row[u];
        if (beside == none || (own != none && std::abs(beside - own) <= step)) continue;
        if (!found.take(beside)) return {};
      }
    }
  }
  return found;
}

struct Rules {
  std::int32_t step = 0;                ///< surfaces differ by more
  float margin = 0, nearer_margin = 0;  ///< by which another surface must be better
  std::int32_t blank = 0;               ///< least value of grey_spread
};

/// 81 times the variance of the 3 x 3 pixels around (x, y).
std::int32_t grey_spread(GrayView image, std::int32_t x, std::int32_t y) {
  std::int32_t sum = 0;
  std::int32_t squares = 0;
  for (std::int32_t v = y - 1; v <= y + 1; ++v) {
    const std::uint8_t* row = image.row(v) + x;
    for (std::int32_t u = -1; u <= 1; ++u) {
      sum += row[u];
      squares += row[u] * row[u];
    }
  }
  return 9 * squares - sum * sum;
}

/// Whether every other surface than candidate `best` is worse by the margin, and there is one: the pixel's own or
/// another candidate.
bool is_clear(const Candidates& candidates, std::size_t best, bool has_own, const Rules& rules) {
  bool others = has_own;
  for (std::int32_t k = 0; k < candidates.count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (std::abs(candidates.quarter_px[i] - candidates.quarter_px[best]) <= rules.step) continue;
    if (candidates.difference[i] < candidates.difference[best] + rules.margin) return false;
    others = true;
  }
  return others;
}

/// What a pixel should do: take a disparity, become empty, or stay as it is.
struct Choice {
  std::int16_t quarter_px = none;
  bool contradicted = false;  ///< by the images, as is the pixel's own disparity: it becomes empty
  float difference = 0;       ///< of its counterparts
  float lead = 0;             ///< by which they differ less than those of its own disparity; 0 without one
};

/// Whether counterparts one step of disparity away are more alike: at a true disparity they are most alike.
bool is_contradicted(const NccRows& rows, std::int32_t x, std::int32_t y, const Choice& choice, std::int32_t step,
                     std::int32_t brightness) {
  for (const std::int32_t d : {choice.quarter_px - step, choice.quarter_px + step}) {
    if (sees_patch(rows, x, y, d) && patch_difference(rows, x, y, d, brightness) < choice.difference) return true;
  }
  return false;
}

/// Share of the surroundings of (x, y) with a disparity that are on the surface with the disparity `chosen`.
float share_around(std::int32_t x, std::int32_t y, std::int16_t chosen, std::int32_t step, EdgeWorkspace& w) {
  std::int32_t known = 0;
  std::int32_t same = 0;
  for (std::int32_t away = edge_reach / 2; away <= edge_reach; away += edge_reach / 2) {
    for (std::int32_t v = y - away; v <= y + away; v += away) {
      const std::int16_t* row = row_of(w, v).data() + edge_reach;
      for (std::int32_t u = x - away; u <= x + away; u += away) {
        if (row[u] == none || (u == x && v == y)) continue;
        ++known;
        same += std::abs(row[u] - chosen) <= step ? 1 : 0;
      }
    }
  }
  return static_cast<float>(same) / static_cast<float>(std::max(known, 1));
}

/// In whole steps of 2^-17 px, the last bit of the sum.
float in_steps(float sigma_px) {
  constexpr float sum_px = 64;
  return (sum_px + sigma_px) - sum_px;
}

/// The error of a pixel that takes `choice`: of the surface where it surely belongs to it, else of the choice.
float taken_sigma(std::int32_t x, std::int32_t y, std::int16_t own, const Choice& choice, std::int32_t step,
                  EdgeWorkspace& w) {
  const float share = share_around(x, y, choice.quarter_px, step, w);
  const float in_grey = 1.0F / quarters_per_px;
  const float window = own == none ? 0 : std::max(0.0F, window_grey - choice.lead * in_grey);
  const float suspicion = choice.difference * in_grey + window + surroundings_grey * (1 - share);
  if (suspicion < most_suspect_grey) return in_steps(right_surface_sigma_px);
  const auto i = static_cast<std::size_t>(x);
  const std::int32_t farthest = std::max(w.highest[i] - choice.quarter_px, choice.quarter_px - (w.lowest[i] + 1));
  const float distance_px = static_cast<float>(farthest) / quarters_per_px;
  return in_steps(std::clamp(suspect_share * distance_px, right_surface_sigma_px, most_sigma_px));
}

/// Sets the difference of (x, y), too.
Choice better_surface(const NccRows& rows, std::int32_t x, std::int32_t y, std::int16_t own, const Rules& rules,
                      EdgeWorkspace& w) {
  const std::int32_t brightness = w.brightness[static_cast<std::size_t>(x / search_tile)];
  if (brightness == unknown_brightness) return {};
  float& stated = w.difference[static_cast<std::size_t>(x)];
  if (own != none) {
    if (!sees_patch(rows, x, y, own)) return {};
    stated = patch_difference(rows, x, y, own, brightness);
    if (stated < rules.margin) return {};
  } else if (grey_spread(rows.left, x, y) < rules.blank) {
    return {};
  }
  Candidates candidates = candidates_of(x, y, own, rules.step, w);
  if (candidates.count == 0) return {};
  std::size_t best = 0;
  for (std::int32_t k = 0; k < candidates.count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const std::int16_t d = candidates.quarter_px[i];
    const bool seen = sees_patch(rows, x, y, d);
    candidates.difference[i] = seen ? patch_difference(rows, x, y, d, brightness) : float{most_difference};
    if (candidates.difference[i] < candidates.difference[best]) best = i;
  }
  const std::int16_t found = candidates.quarter_px[best];
  const float margin = found > own ? rules.nearer_margin : rules.margin;
  const float most = own == none ? most_alike : stated - margin;
  if (candidates.difference[best] > most || !is_clear(candidates, best, own != none, rules)) return {};
  Choice choice;
  choice.quarter_px = found;
  choice.difference = candidates.difference[best];
  choice.lead = own == none ? 0 : stated - choice.difference;
  choice.contradicted = is_contradicted(rows, x, y, choice, rules.step, brightness);
  stated = choice.difference;
  return choice;
}

/// Gives every right pixel to the left pixel that differs least from it, and takes the disparity of all others at edges
/// that claim it for another surface.
void share_out(std::int32_t width, std::int32_t step, std::int16_t* own, float* sigma_px, EdgeWorkspace& w) {
  constexpr auto columns = static_cast<std::size_t>(limits::max_rectified_width);
  // One more than the right pixel; 0 for none.
  std::array<std::int16_t, columns> target;
  std::int16_t* __restrict found = target.data();
  const std::int16_t* __restrict quarters = own;
  for (std::int32_t x = 0; x < width; ++x) {
    const std::int32_t seen = x - whole_px(quarters[x]);
    const int inside =
        static_cast<int>(quarters[x] != none) & static_cast<int>(seen >= 0) & static_cast<int>(seen < width);
    found[x] = static_cast<std::int16_t>(inside != 0 ? seen + 1 : 0);
  }
  // Few right pixels are claimed by a left one at an edge; only these are given away.
  std::array<std::uint8_t, columns + 1> claimed{};
  const float* difference = w.difference.data();
  const auto at_edge = [=](std::int32_t x) {
    return static_cast<int>(difference[x] >= 0) & static_cast<int>(found[x] != 0);
  };
  for_each_flagged(0, width, at_edge, [&](std::int32_t x) {
    const std::int32_t t = found[x] - 1;
    claimed[static_cast<std::size_t>(t) + 1] = 1;
    w.right_difference[static_cast<std::size_t>(t)] = std::numeric_limits<float>::max();
  });
  for (std::int32_t x = 0; x < width; ++x) {
    const std::int16_t k = found[x];
    if (claimed[static_cast<std::size_t>(k)] == 0) continue;
    const auto t = static_cast<std::size_t>(k - 1);
    if (difference[x] >= w.right_difference[t]) continue;
    w.right_difference[t] = difference[x];
    w.right_quarters[t] = own[x];
  }
  for_each_flagged(0, width, at_edge, [&](std::int32_t x) {
    const auto t = static_cast<std::size_t>(found[x] - 1);
    if (std::abs(w.right_quarters[t] - own[x]) <= step || w.right_difference[t] >= difference[x]) return;
    own[x] = none;
    sigma_px[x] = 0;
  });
}

void decide_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                EdgeWorkspace& w) {
  const std::int32_t width = map.sigma_px.width;
  const auto in_quarters = [](double value) { return static_cast<float>(value * quarters_per_px); };
  const double noise = params.noise_grey;
  const Rules rules{static_cast<std::int32_t>(in_quarters(params.surface_step_px)), in_quarters(margin_noises * noise),
                    in_quarters(nearer_margin_noises * noise),
                    static_cast<std::int32_t>(81 * texture_noises * texture_noises * noise * noise)};
  find_ranges(y, width, w);
  std::fill_n(w.difference.begin(), width, -1.0F);
  std::int16_t* own = row_of(w, y).data() + edge_reach;
  bool edges = false;
  const std::int16_t* lowest = w.lowest.data();
  const std::int16_t* highest = w.highest.data();
  const std::uint8_t* valid = rows.left_valid.row(y);
  const auto suspect = [=, step = rules.step](std::int32_t x) {
    return is_at_edge(lowest[x] + 1, highest[x], own[x], step) & static_cast<int>(valid[x] != 0);
  };
  for_each_flagged(patch_radius, width - patch_radius - 1, suspect, [&](std::int32_t x) {
    const Choice choice = better_surface(rows, x, y, own[x], rules, w);
    edges = edges || w.difference[static_cast<std::size_t>(x)] >= 0;
    if (choice.quarter_px == none) return;
    if (choice.contradicted) {
      own[x] = none;
      map.sigma_px.at(x, y) = 0;
      return;
    }
    map.sigma_px.at(x, y) = taken_sigma(x, y, own[x], choice, rules.step, w);
    map.kind.at(x, y) = DisparityKind::resolved;
    own[x] = choice.quarter_px;
    map.disparity_px.at(x, y) = static_cast<float>(choice.quarter_px) / quarters_per_px;
  });
  if (edges) share_out(width, rules.step, own, map.sigma_px.row(y), w);
}

void decide_edges(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                  EdgeWorkspace& w) {
  if (!(params.surface_step_px > 0)) return;
  if (y == 0) {
    for (std::int32_t above = -edge_reach; above < 0; ++above) row_of(w, above).fill(none);
  }
  take_row(map.disparity_px, map.sigma_px, y, row_of(w, y));
  const std::int32_t target = y - edge_reach;
  if (target < 0 || target >= map.sigma_px.height) return;
  if (target % search_tile == 0) measure_brightness(rows, target, map.disparity_px, map.sigma_px, w);
  if (target < patch_radius || target >= map.sigma_px.height - patch_radius) return;
  decide_row(rows, params, target, map, w);
}

}  // namespace

void decide_edges_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                      EdgeWorkspace& w) {
  with_widest_vectors([&] { decide_edges(rows, params, y, map, w); });
}

}  // namespace ilp
