#include "fsw/vision/place/place_features.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/image/sampling.hpp"
#include "fsw/vision/place/place_feature_workspace.hpp"

namespace ilp {
namespace {

// 0.75 / 1.26^level and the share of the features in 256, both by level.
constexpr std::int32_t level_scale_q16[place_levels] = {49152, 39010, 30960, 24571, 19501};
constexpr std::int32_t level_share_256[place_levels] = {105, 66, 42, 26, 17};
static_assert(105 + 66 + 42 + 26 + 17 == 256);

constexpr std::int32_t min_distance_px = 7;
constexpr std::int32_t pattern_radius_px = 16;
constexpr std::int32_t orientation_radius_px = 15;
constexpr std::int32_t box_reach_px = 2;
// A point of the pattern may move outwards by less than a pixel when it is turned and rounded.
constexpr std::int32_t border_px = pattern_radius_px + 1 + box_reach_px + 1;
static_assert(border_px > orientation_radius_px);

struct PointPair {
  std::int32_t ax, ay, bx, by;
};

// Pairs of points with nearly normal coordinates, as in M. Calonder et al., "BRIEF", ECCV 2010.
struct Pattern {
  PointPair pairs[256] = {};

  constexpr Pattern() {
    Rng rng(0x706C616365);
    std::size_t count = 0;
    while (count < 256) {
      const PointPair p{coordinate(rng), coordinate(rng), coordinate(rng), coordinate(rng)};
      const int dx = p.ax - p.bx, dy = p.ay - p.by;
      // Points that are too near to each other compare noise.
      if (inside(p.ax, p.ay) && inside(p.bx, p.by) && dx * dx + dy * dy >= 16) pairs[count++] = p;
    }
  }

 private:
  // The sum of four uniform numbers from -7 to 7 px: a standard deviation of 8.6 px.
  static constexpr std::int32_t coordinate(Rng& rng) {
    std::int32_t sum = -28;
    for (int k = 0; k < 4; ++k) sum += static_cast<std::int32_t>(rng.below(15));
    return sum;
  }
  static constexpr bool inside(int x, int y) { return x * x + y * y <= pattern_radius_px * pattern_radius_px; }
};
constexpr Pattern pattern;

// Distances from the middle of the pixels of a disc; 0 outside of it. Rows are filled up to whole vectors.
struct Disc {
  static constexpr std::int32_t rows = 2 * orientation_radius_px + 1, stride = 32;
  std::int16_t along_x[rows * stride] = {}, along_y[rows * stride] = {};

  constexpr Disc() {
    for (std::int32_t y = -orientation_radius_px; y <= orientation_radius_px; ++y) {
      for (std::int32_t x = -orientation_radius_px; x <= orientation_radius_px; ++x) {
        if (x * x + y * y > orientation_radius_px * orientation_radius_px) continue;
        const std::int32_t at = (y + orientation_radius_px) * stride + x + orientation_radius_px;
        along_x[at] = static_cast<std::int16_t>(x);
        along_y[at] = static_cast<std::int16_t>(y);
      }
    }
  }
};
constexpr Disc disc;
static_assert(Disc::rows <= Disc::stride && orientation_radius_px + 1 < border_px);

// The points of all pairs, those of one kind side by side.
struct PatternPoints {
  static constexpr std::size_t count = std::size(pattern.pairs);
  std::int32_t x[2 * count] = {}, y[2 * count] = {};  ///< first all points a, then all points b

  constexpr PatternPoints() {
    for (std::size_t k = 0; k < count; ++k) {
      x[k] = pattern.pairs[k].ax;
      y[k] = pattern.pairs[k].ay;
      x[count + k] = pattern.pairs[k].bx;
      y[count + k] = pattern.pairs[k].by;
    }
  }
};
constexpr PatternPoints points;

/// Where the middle of pixel x of `to_side` lies among `from_side`, the outer borders of both on each other.
FixedCoordinate position(std::int32_t x, std::int32_t from_side, std::int32_t to_side) {
  const double centre = (x + 0.5) * from_side / to_side - 0.5;
  return std::clamp(to_fixed(centre), 0, ((from_side - 1) << 16) - 1);
}

/// 256 times the grey values between two rows, `share` / 256 of the way down.
void blend(const std::uint8_t* upper, const std::uint8_t* lower, std::int32_t width, std::int32_t share,
           std::uint16_t* __restrict out) {
  for (std::int32_t x = 0; x < width; ++x) {
    out[x] = static_cast<std::uint16_t>((upper[x] << 8) + share * (lower[x] - upper[x]));
  }
}

/// Grey values between two neighbours of a blended row, which are the halves of a pair, the left one in the lower half.
void blend_across(const std::uint32_t* pairs, const FixedCoordinate* across, std::int32_t width,
                  std::uint8_t* __restrict out) {
  for (std::int32_t x = 0; x < width; ++x) {
    const auto left = static_cast<std::int32_t>(pairs[x] & 0xFFFFU), right = static_cast<std::int32_t>(pairs[x] >> 16U);
    const std::int32_t value = (left << 8) + ((across[x] >> 8) & 255) * (right - left);
    out[x] = static_cast<std::uint8_t>((value + (1 << 15)) >> 16);
  }
}

std::uint32_t load_pair(const std::uint16_t* at) {
  std::uint32_t pair = 0;
  std::memcpy(&pair, at, sizeof(pair));
  return std::endian::native == std::endian::little ? pair : (pair >> 16U) | (pair << 16U);
}

// As sample_bilinear() at every pixel, down first. Only the loads go pixel by pixel.
void resample(GrayView from, MutableGrayView to) {
  std::array<FixedCoordinate, limits::max_image_side> across;
  std::array<std::uint32_t, limits::max_image_side> pixel;
  for (std::int32_t x = 0; x < to.width; ++x) {
    const auto i = static_cast<std::size_t>(x);
    across[i] = position(x, from.width, to.width);
    pixel[i] = static_cast<std::uint32_t>(across[i] >> 16);
  }
  std::array<std::uint16_t, limits::max_image_side> blended;
  std::array<std::uint32_t, limits::max_image_side> pairs;
  with_widest_vectors([&] {
    for (std::int32_t y = 0; y < to.height; ++y) {
      const FixedCoordinate v = position(y, from.height, to.height);
      const std::uint8_t* const upper = from.row(v >> 16);
      blend(upper, upper + from.stride, from.width, (v >> 8) & 255, blended.data());
      const auto width = static_cast<std::size_t>(to.width);
#pragma GCC unroll 4
      for (std::size_t x = 0; x < width; ++x) pairs[x] = load_pair(blended.data() + pixel[x]);
      blend_across(pairs.data(), across.data(), to.width, to.row(y));
    }
  });
}

// Sums over (2 box_reach_px + 1)^2 pixels, for all pixels but a border of that reach.
void smooth(GrayView image, PlaceFeatureWorkspace& w) {
  constexpr std::int32_t r = box_reach_px;
  static_assert(r == 2);
  with_widest_vectors([&] {
    std::uint16_t* const __restrict columns = w.columns.data();
    for (std::int32_t y = r; y < image.height - r; ++y) {
      const std::uint8_t *a = image.row(y - 2), *b = image.row(y - 1), *c = image.row(y), *d = image.row(y + 1),
                         *e = image.row(y + 2);
      for (std::int32_t x = 0; x < image.width; ++x) {
        columns[x] = static_cast<std::uint16_t>(a[x] + b[x] + c[x] + d[x] + e[x]);
      }
      std::uint16_t* const __restrict out = w.smooth.data() + static_cast<std::ptrdiff_t>(y) * image.width;
      for (std::int32_t x = r; x < image.width - r; ++x) {
        out[x] =
            static_cast<std::uint16_t>(columns[x - 2] + columns[x - 1] + columns[x] + columns[x + 1] + columns[x + 2]);
      }
    }
  });
}

// Direction from the corner to the centroid of the grey values around it (P. Rosin, "Measuring corner properties",
// 1999).
std::uint8_t orientation(GrayView image, std::int32_t x, std::int32_t y) {
  std::int16_t grey[Disc::rows * Disc::stride];
  for (std::int32_t row = 0; row < Disc::rows; ++row) {
    const std::uint8_t* const from = image.row(y + row - orientation_radius_px) + x - orientation_radius_px;
    for (std::int32_t k = 0; k < Disc::stride; ++k) grey[row * Disc::stride + k] = from[k];
  }
  std::int32_t moment_x = 0, moment_y = 0;
  for (std::int32_t i = 0; i < Disc::rows * Disc::stride; ++i) {
    moment_x += disc.along_x[i] * grey[i];
    moment_y += disc.along_y[i] * grey[i];
  }
  const double turns = det_atan2(moment_y, moment_x) * (128 / pi);
  return static_cast<std::uint8_t>(static_cast<std::int32_t>(std::floor(turns + 0.5)) & 255);
}

void describe(const std::uint16_t* centre, std::int32_t stride, PlaceFeature& feature) {
  const double angle = feature.angle * (pi / 128);
  const auto c = static_cast<std::int32_t>(std::floor(det_cos(angle) * 16384 + 0.5));
  const auto s = static_cast<std::int32_t>(std::floor(det_sin(angle) * 16384 + 0.5));
  constexpr std::size_t count = PatternPoints::count;
  std::int32_t offset[2 * count], value[2 * count];
  for (std::size_t i = 0; i < 2 * count; ++i) {
    const std::int32_t x = points.x[i], y = points.y[i];
    offset[i] = ((x * s + y * c + 8192) >> 14) * stride + ((x * c - y * s + 8192) >> 14);
  }
#pragma GCC unroll 4
  for (std::size_t i = 0; i < 2 * count; ++i) value[i] = centre[offset[i]];
  for (std::size_t word = 0; word < 8; ++word) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 32; ++k) {
      bits |= (value[32 * word + k] < value[count + 32 * word + k] ? 1U : 0U) << k;
    }
    feature.descriptor[word] = bits;
  }
}

/// The levels lie in two regions in turn; the one before is needed for the next.
MutableGrayView level_of(GrayView image, int level, PlaceFeatureWorkspace& w) {
  const std::int32_t width = (image.width * level_scale_q16[level] + 32768) >> 16;
  const std::int32_t height = (image.height * level_scale_q16[level] + 32768) >> 16;
  return {level % 2 == 0 ? w.level.data() : w.next_level.data(), width, height};
}

HarrisParams corner_params(int level, std::size_t wanted) {
  const auto all = static_cast<std::int32_t>(std::min(wanted, limits::max_place_features));
  HarrisParams params;
  params.target_count = level_share_256[level] * all / 256;
  params.border_px = border_px;
  params.min_distance_px = min_distance_px;
  return params;
}

Status describe_corners(GrayView image, GrayView level, PlaceFeatureWorkspace& w, PlaceFeatures& features) {
  smooth(level, w);
  const double x_scale = static_cast<double>(image.width) / level.width;
  const double y_scale = static_cast<double>(image.height) / level.height;
  for (const Corner& corner : w.corners) {
    const auto x = static_cast<std::int32_t>(std::floor(corner.x + 0.5F));
    const auto y = static_cast<std::int32_t>(std::floor(corner.y + 0.5F));
    PlaceFeature feature;
    feature.x = static_cast<float>((corner.x + 0.5) * x_scale - 0.5);
    feature.y = static_cast<float>((corner.y + 0.5) * y_scale - 0.5);
    feature.level = static_cast<std::uint8_t>(w.progress.at_level);
    with_widest_vectors([&] {
      feature.angle = orientation(level, x, y);
      describe(w.smooth.data() + static_cast<std::ptrdiff_t>(y) * level.width + x, level.width, feature);
    });
    ILP_ASSERT(features.push_back(feature), features.size());
  }
  return {};
}

}  // namespace

Status begin_place_features(GrayView image, PlaceFeatureWorkspace& w, PlaceFeatures& features) {
  features.clear();
  w.progress.at_level = 0;
  w.progress.level_begun = w.progress.corners_found = false;
  if (image.area() > limits::max_image_pixels || std::max(image.width, image.height) > limits::max_image_side) {
    return {StatusCode::image_too_large, image.width, image.height};
  }
  return {};
}

Result<bool> place_features_slice(GrayView image, std::size_t wanted, HarrisWorkspace& harris, PlaceFeatureWorkspace& w,
                                  PlaceFeatures& features) {
  if (w.progress.at_level == place_levels) return false;
  const MutableGrayView level = level_of(image, w.progress.at_level, w);
  if (std::min(level.width, level.height) <= 2 * border_px) return false;
  const HarrisParams params = corner_params(w.progress.at_level, wanted);
  if (!w.progress.level_begun) {
    resample(w.progress.at_level == 0 ? image : GrayView(level_of(image, w.progress.at_level - 1, w)), level);
    w.progress.level_begun = true;
    ILP_TRY(begin_corners(level, params, harris, w.corners));
    return true;
  }
  if (!w.progress.corners_found) {
    ILP_TAKE(const bool more, detect_corners_slice(level, params, harris, w.corners));
    w.progress.corners_found = !more;
    return true;
  }
  ILP_TRY(describe_corners(image, level, w, features));
  ++w.progress.at_level;
  w.progress.level_begun = w.progress.corners_found = false;
  return true;
}

Status find_place_features(GrayView image, std::size_t wanted, HarrisWorkspace& harris, PlaceFeatureWorkspace& w,
                           PlaceFeatures& features) {
  ILP_TRY(begin_place_features(image, w, features));
  return do_all([&] { return place_features_slice(image, wanted, harris, w, features); });
}

}  // namespace ilp
