#include "fsw/vision/stereo/match/gap_support.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/lanes.hpp"
#include "fsw/vision/stereo/match/flagged_columns.hpp"

namespace ilp {
namespace {

// Disparities are resampled in quarters of a pixel.
constexpr std::int32_t quarters = 4;
constexpr std::int32_t support_radius = 8;
// Fewer pixels correlate by chance.
constexpr std::int32_t least_support = 15;
// Correlation of what is weak but seen, and of noise: its standard deviation is 1 / sqrt(pixels).
constexpr float least_correlation = 0.25F, noise_deviations = 2.5F;
// Brightness within so many sigmas of noise is the same surface.
constexpr double same_surface_sigmas = 4;
// Damps the correlation: noise of a good sensor, because the pixels are many.
constexpr float damping_grey = 0.3F;
// Errors of a plane through agreeing matches: its own, and what the ground does between them, per px of the gap.
constexpr float plane_sigma_px = 0.2F, sigma_per_px = 0.005F;
// Of the difference of both ends, and of the distance between the planes of all directions.
constexpr float disagreement_share = 0.35F;
// Where one direction only has matches on both sides, nothing confirms its plane.
constexpr float lonely_sigma_px = 0.3F;
// Largest difference of the disparities on both sides: no depth edge between them.
constexpr float gap_step_px = 1;
// Share of a gap that must be supported and confirmed, or all of it is empty.
constexpr std::int32_t gap_least_percent = 15;

constexpr std::array<std::int32_t, 3> steps_x = {0, 1, -1};

/// The planes through matches on opposite sides of a pixel, in up to four directions.
struct PlanesAcross {
  std::int32_t count = 0;
  float lowest_px = 0, highest_px = 0;  ///< their disparities
  // Of the plane with the shortest gap between both matches:
  std::int32_t length = 0;
  float disparity_px = 0, difference_px = 0;  ///< the difference is that of its ends
};

/// The nearest matches on both sides along one line, in pixels of that line.
struct Sides {
  std::int32_t before = 0, after = 0;  ///< 0: none
  float before_px = 0, after_px = 0;
};

void consider(const Sides& sides, const StereoParams& params, PlanesAcross& planes) {
  const std::int32_t reach = params.gap_reach_px;
  if (sides.before < 1 || sides.after < 1 || sides.before > reach || sides.after > reach) return;
  const float difference = sides.before_px - sides.after_px;
  if (std::fabs(difference) > gap_step_px) return;
  const std::int32_t length = sides.before + sides.after;
  const auto towards_after = static_cast<float>(sides.before) / static_cast<float>(length);
  const float disparity = sides.before_px - towards_after * difference;
  const bool first = planes.count++ == 0;
  planes.lowest_px = first ? disparity : std::min(planes.lowest_px, disparity);
  planes.highest_px = first ? disparity : std::max(planes.highest_px, disparity);
  if (!first && length >= planes.length) return;
  planes.length = length;
  planes.disparity_px = disparity;
  planes.difference_px = difference;
}

float sigma_of(const PlanesAcross& planes) {
  const float ends = disagreement_share * planes.difference_px;
  const float spread = disagreement_share * (planes.highest_px - planes.lowest_px);
  const float ground = sigma_per_px * static_cast<float>(planes.length);
  const float lonely = planes.count == 1 ? lonely_sigma_px : 0;
  return std::sqrt(plane_sigma_px * plane_sigma_px + ends * ends + spread * spread + ground * ground + lonely * lonely);
}

bool is_gap(MaskView left_valid, const DisparityView& map, std::int32_t x, std::int32_t y) {
  return left_valid.at(x, y) != 0 && !is_matched(map.kind.at(x, y));
}

/// The same for the columns of a row, for for_each_flagged.
auto gap_flag(MaskView left_valid, const DisparityView& map, std::int32_t y) {
  return [valid = left_valid.row(y), kind = map.kind.row(y)](std::int32_t x) {
    return static_cast<int>(valid[x] != 0) & static_cast<int>(!is_matched(kind[x]));
  };
}

/// Whether the gap that (x, y) begins along a line ends at a match, whose row is `below`.
[[gnu::always_inline]] inline bool find_end(MaskView left_valid, const DisparityView& map, std::int32_t x,
                                            std::int32_t y, std::int32_t step, std::int16_t& below) {
  const std::int32_t width = map.sigma_px.width, height = map.sigma_px.height;
  std::int32_t v = y + 1;
  std::int32_t w = x + step;
  while (v < height && w >= 0 && w < width && is_gap(left_valid, map, w, v)) {
    ++v;
    w += step;
  }
  below = static_cast<std::int16_t>(v);
  return v < height && w >= 0 && w < width && is_matched(map.kind.at(w, v));
}

/// Makes `line` that of the gap pixel (x, y). A line of gap pixels is searched for its end once, and only if a match is
/// above them.
[[gnu::always_inline]] inline void follow(MaskView left_valid, const DisparityView& map, std::int32_t x, std::int32_t y,
                                          std::int32_t step, GapLine& line) {
  if (line.next != y) {
    const std::int32_t u = x - step;
    const bool inside = y > 0 && u >= 0 && u < map.sigma_px.width;
    line.above = static_cast<std::int16_t>(y - 1);
    line.closed = inside && is_matched(map.kind.at(u, y - 1)) && find_end(left_valid, map, x, y, step, line.below);
  }
  line.next = static_cast<std::int16_t>(y + 1);
}

Sides sides_down(ImageView<const float> disparity_px, std::int32_t x, std::int32_t y, std::int32_t step,
                 const GapLine& line) {
  Sides sides;
  if (!line.closed) return sides;
  sides.before = y - line.above;
  sides.after = line.below - y;
  sides.before_px = disparity_px.at(x - step * sides.before, line.above);
  sides.after_px = disparity_px.at(x + step * sides.after, line.below);
  return sides;
}

struct Sums {
  std::int32_t count = 0, left = 0, right = 0;
  std::int64_t left_squares = 0, right_squares = 0, products = 0;
};

/// What is compared over a gap: pixels as bright as the one in question, the right image at a disparity in quarters.
struct GapWindow {
  std::int32_t whole, fraction;    ///< of the disparity; whole pixels rounded up, so that the fraction adds to them
  std::int32_t centre, same_grey;  ///< grey value and how far others may be from it
  std::int32_t first, last;        ///< columns
};

/// One pixel of a row.
[[gnu::always_inline]] inline void add_pixel(const GapWindow& g, const std::uint8_t* left, const std::uint8_t* right,
                                             const std::uint8_t* valid, const DisparityKind* kind, std::int32_t u,
                                             Sums& sums) {
  const std::int32_t difference = left[u] - g.centre;
  if (is_matched(kind[u]) || valid[u] == 0 || difference > g.same_grey || difference < -g.same_grey) return;
  const std::int32_t l = left[u];
  const std::int32_t r = right[u - g.whole] * (quarters - g.fraction) + right[u - g.whole + 1] * g.fraction;
  ++sums.count;
  sums.left += l;
  sums.right += r;
  sums.left_squares += std::int64_t{l} * l;
  sums.right_squares += std::int64_t{r} * r;
  sums.products += std::int64_t{l} * r;
}

using lanes::I16;
using lanes::I32;

/// Eight columns, over the rows of a window: sums of words, and of products of pairs of columns.
struct LaneSums {
  I16 count{}, left{}, right{};
  I32 left_squares{}, right_squares{}, products{};

  /// Columns from u on, those of `in_window` only.
  [[gnu::always_inline]] void add(const GapWindow& g, const std::uint8_t* left_row, const std::uint8_t* right_row,
                                  const std::uint8_t* valid, const DisparityKind* kind, std::int32_t u, I16 in_window) {
    const I16 grey = lanes::words_at(left_row + u);
    const I16 difference = grey - static_cast<std::int16_t>(g.centre);
    const auto most = static_cast<std::int16_t>(g.same_grey);
    const I16 kinds = lanes::words_at(reinterpret_cast<const std::uint8_t*>(kind + u));
    constexpr auto supported = static_cast<std::int16_t>(DisparityKind::supported);
    const I16 takes = in_window & ((kinds & ~supported) == 0) & (lanes::words_at(valid + u) != 0) &
                      (difference <= most) & (difference >= static_cast<std::int16_t>(-most));
    const I16 l = grey & takes;
    const I16 r = (lanes::words_at(right_row + u - g.whole) * static_cast<std::int16_t>(quarters - g.fraction) +
                   lanes::words_at(right_row + u - g.whole + 1) * static_cast<std::int16_t>(g.fraction)) &
                  takes;
    count -= takes;
    left += l;
    right += r;
    left_squares += lanes::products_of(l, l);
    right_squares += lanes::products_of(r, r);
    products += lanes::products_of(l, r);
  }
  void add_to(Sums& sums) const {
    for (int i = 0; i < lanes::words; ++i) {
      sums.count += count[i];
      sums.left += left[i];
      sums.right += right[i];
    }
    for (int i = 0; i < lanes::words / 2; ++i) {
      sums.left_squares += left_squares[i];
      sums.right_squares += right_squares[i];
      sums.products += products[i];
    }
  }
};

/// Over the gap pixels near (x, y) that are as bright as it; the right image is at `quarter_px` quarters.
[[gnu::always_inline]] inline Sums sums_over_gap(const NccRows& rows, const DisparityView& map, std::int32_t x,
                                                 std::int32_t y, std::int32_t quarter_px, std::int32_t same_grey) {
  GapWindow g;
  g.whole = -(-quarter_px >> 2);
  g.fraction = g.whole * quarters - quarter_px;
  g.centre = rows.left.at(x, y);
  g.same_grey = same_grey;
  g.first = std::max({0, x - support_radius, g.whole});
  g.last = std::min({rows.left.width - 1, x + support_radius, rows.left.width - 2 + g.whole});
  Sums sums;
  // Sixteen columns as vectors, where both rows have them; the last column by itself.
  constexpr std::int32_t in_vectors = 2 * lanes::words;
  static_assert(2 * support_radius + 1 == in_vectors + 1);
  const std::int32_t columns = g.last - g.first + 1;
  const bool fits = g.first + in_vectors <= rows.left.width && g.first + in_vectors - g.whole < rows.right.width;
  const std::int32_t single = fits ? std::min(g.first + in_vectors, g.last + 1) : g.first;
  const I16 column = {0, 1, 2, 3, 4, 5, 6, 7};
  const I16 in_first = column < static_cast<std::int16_t>(columns);
  const I16 in_second = column + std::int16_t{lanes::words} < static_cast<std::int16_t>(columns);
  LaneSums first, second;
  for (std::int32_t v = std::max(0, y - support_radius); v <= std::min(rows.left.height - 1, y + support_radius); ++v) {
    const std::uint8_t* left = rows.left.row(v);
    const std::uint8_t* right = rows.right.row(v);
    const std::uint8_t* valid = rows.left_valid.row(v);
    const DisparityKind* kind = map.kind.row(v);
    if (fits) {
      first.add(g, left, right, valid, kind, g.first, in_first);
      second.add(g, left, right, valid, kind, g.first + lanes::words, in_second);
    }
    for (std::int32_t u = single; u <= g.last; ++u) add_pixel(g, left, right, valid, kind, u, sums);
  }
  first.add_to(sums);
  second.add_to(sums);
  return sums;
}

/// Whether the images confirm a disparity of the gap pixel (x, y).
[[gnu::always_inline]] inline bool is_seen_again(const NccRows& rows, const DisparityView& map, std::int32_t x,
                                                 std::int32_t y, float d, std::int32_t same_grey) {
  const auto quarter_px = static_cast<std::int32_t>(std::floor(d * quarters + 0.5F));
  const std::int32_t target = x - ((quarter_px + 2) >> 2);
  if (target < 0 || target >= rows.right.width || rows.right_valid.at(target, y) == 0) return false;
  const Sums sums = sums_over_gap(rows, map, x, y, quarter_px, same_grey);
  if (sums.count < least_support) return false;
  // Times the count, and grey values of the right image times four.
  const std::int64_t n = sums.count;
  const auto count = static_cast<float>(n);
  const auto both = static_cast<float>(n * sums.products - std::int64_t{sums.left} * sums.right);
  if (!(both > 0)) return false;
  const float damping = count * count * damping_grey * damping_grey;
  const float left = static_cast<float>(n * sums.left_squares - std::int64_t{sums.left} * sums.left) + damping;
  const float right = static_cast<float>(n * sums.right_squares - std::int64_t{sums.right} * sums.right) +
                      damping * static_cast<float>(quarters * quarters);
  const float least2 = std::max(least_correlation * least_correlation, noise_deviations * noise_deviations / count);
  return both * both >= least2 * left * right;
}

// A gap's sum is positive in the forest: every sum is this much larger.
constexpr std::int32_t sum_offset = 1 << 30;
static_assert(limits::max_rectified_pixels < sum_offset / 100,
              "sums of percents stay below it, and with it in 32 bits");
// In a small gap a few pixels correlate by chance.
constexpr std::int32_t pixels_by_chance = 5;

}  // namespace

void begin_gaps(GapWorkspace& workspace) {
  for (auto& lines : workspace.down) lines.fill({});
  workspace.proposals = 0;
}

namespace {

void propose_gaps(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                  GapWorkspace& workspace) {
  const std::int32_t width = map.sigma_px.width;
  const auto same_grey = static_cast<std::int32_t>(std::lround(same_surface_sigmas * params.noise_grey));
  std::int32_t run_end = 0;
  std::int32_t run_begin = 0;
  for_each_flagged(0, width, gap_flag(rows.left_valid, map, y), [&](std::int32_t x) {
    if (x >= run_end) {
      run_begin = x;
      for (run_end = x + 1; run_end < width && is_gap(rows.left_valid, map, run_end, y);) ++run_end;
    }
    PlanesAcross planes;
    Sides across;
    if (run_begin > 0 && run_end < width && is_matched(map.kind.at(run_begin - 1, y)) &&
        is_matched(map.kind.at(run_end, y))) {
      across = {x - run_begin + 1, run_end - x, map.disparity_px.at(run_begin - 1, y), map.disparity_px.at(run_end, y)};
    }
    consider(across, params, planes);
    for (std::size_t k = 0; k < steps_x.size(); ++k) {
      const std::int32_t step = steps_x[k];
      // Pixels of one line have one number.
      const std::int32_t number = x - step * y + (step > 0 ? map.sigma_px.height - 1 : 0);
      GapLine& line = workspace.down[k][static_cast<std::size_t>(number)];
      follow(rows.left_valid, map, x, y, step, line);
      consider(sides_down(map.disparity_px, x, y, step, line), params, planes);
    }
    if (planes.count == 0 || !is_seen_again(rows, map, x, y, planes.disparity_px, same_grey)) return;
    map.disparity_px.at(x, y) = planes.disparity_px;
    map.sigma_px.at(x, y) = sigma_of(planes);
    map.kind.at(x, y) = DisparityKind::supported;
    ++workspace.proposals;
  });
}

}  // namespace

void propose_gap_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                     GapWorkspace& workspace) {
  with_widest_vectors([&] { propose_gaps(rows, params, y, map, workspace); });
}

namespace {

void connect_gaps(MaskView left_valid, const DisparityView& map, std::int32_t y, PixelForest& workspace) {
  std::int32_t* links = workspace.links.data();
  const std::int32_t width = map.sigma_px.width;
  const std::int32_t row = y * width;
  std::int32_t end = 0;
  for_each_flagged(0, width, gap_flag(left_valid, map, y), [&](std::int32_t begin) {
    if (begin < end) return;
    // A tree of every run of gap pixels.
    std::int32_t proposed = 0;
    for (end = begin; end < width && is_gap(left_valid, map, end, y); ++end) {
      proposed += map.kind.at(end, y) == DisparityKind::supported ? 1 : 0;
      links[row + end] = row + begin;
    }
    links[row + begin] = -(sum_offset + 100 * proposed - gap_least_percent * (end - begin));
    if (y == 0) return;
    bool joined = false;
    for (std::int32_t x = begin; x < end; ++x) {
      const bool gap_above = is_gap(left_valid, map, x, y - 1);
      if (gap_above && !joined) join(links, row + begin, row - width + x, sum_offset);
      joined = gap_above;
    }
  });
}

void accept_gaps(const DisparityView& map, std::int32_t y, PixelForest& workspace) {
  std::int32_t* links = workspace.links.data();
  DisparityKind* const kind = map.kind.row(y);
  const auto is_proposed = [kind](std::int32_t x) { return static_cast<int>(kind[x] == DisparityKind::supported); };
  for_each_flagged(0, map.sigma_px.width, is_proposed, [&](std::int32_t x) {
    if (-links[root_of(links, y * map.sigma_px.width + x)] >= sum_offset + 100 * pixels_by_chance) return;
    kind[x] = DisparityKind::none;
    map.sigma_px.at(x, y) = 0;
  });
}

}  // namespace

void connect_gap_row(MaskView left_valid, const DisparityView& map, std::int32_t y, PixelForest& workspace) {
  with_widest_vectors([&] { connect_gaps(left_valid, map, y, workspace); });
}

void accept_gap_row(const DisparityView& map, std::int32_t y, PixelForest& workspace) {
  with_widest_vectors([&] { accept_gaps(map, y, workspace); });
}

}  // namespace ilp
