#include "sim/tools/score/ground_value.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <system_error>

#include "sim/host/image_io.hpp"
#include "sim/host/statistics.hpp"
#include "sim/tools/score/quality_score.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::score {
namespace {
namespace fs = std::filesystem;

// A feature of which nothing has come: as if the image were grey.
constexpr double unseen_squares = 64.0 * 64.0;
constexpr int disc_steps = 4;  // each way from the centre
constexpr std::int32_t window_px = 2;

bool counts(const world::PlantedFeature& feature) {
  // Single stones are too many and too small to be what a mission looks for; fields of them are.
  return feature.kind != world::FeatureKind::rock;
}

std::vector<Vec3> disc_of(const world::PlantedFeature& feature, const world::HeightGrid& truth) {
  std::vector<Vec3> points;
  for (int j = -disc_steps; j <= disc_steps; ++j) {
    for (int i = -disc_steps; i <= disc_steps; ++i) {
      if (i * i + j * j > disc_steps * disc_steps) continue;
      const double x = feature.x + feature.radius_m * i / disc_steps, y = feature.y + feature.radius_m * j / disc_steps;
      const double z = world::height_at(truth, x, y);
      if (!std::isfinite(z)) return {};
      points.emplace_back(x, y, z);
    }
  }
  return points;
}

/// Signed error in the truth's unit, NaN where nothing came down.
std::pair<double, double> error_at(const std::vector<StripErrors>& strips, std::int32_t i, std::int32_t j) {
  for (const StripErrors& strip : strips) {
    const float error = strip.map->at(i, j);
    if (std::isfinite(error)) return {error, strip.flying_height};
  }
  return {unknown, 1};
}

struct Pair {
  const world::TrueFrame* frame = nullptr;
  const host::Raster<std::uint8_t>* decoded = nullptr;
  host::Raster<std::uint8_t> original;
};

std::vector<Pair> image_pairs(const intake::Flight& flight, TrueFrames& frames, const fs::path& images) {
  std::vector<Pair> pairs;
  for (const auto& [id, keyframe] : flight.keyframes) {
    std::error_code error;
    if (keyframe.image.empty() || !fs::is_regular_file(images / keyframe.name, error)) continue;
    Pair pair;
    pair.frame = frames.sampled(keyframe.name);
    pair.decoded = &keyframe.image;
    if (pair.frame == nullptr) continue;
    try {
      pair.original = host::read_gray(images / keyframe.name);
    } catch (const std::exception&) {
      continue;
    }
    if (keyframe.image.same_size(pair.original.width, pair.original.height)) pairs.push_back(std::move(pair));
  }
  return pairs;
}

/// Mean squared error around a pixel.
double squares_around(const Pair& pair, const Vec2& pixel) {
  const auto column = static_cast<std::int32_t>(std::lround(pixel.x()));
  const auto row = static_cast<std::int32_t>(std::lround(pixel.y()));
  double sum = 0, count = 0;
  for (std::int32_t y = row - window_px; y <= row + window_px; ++y) {
    for (std::int32_t x = column - window_px; x <= column + window_px; ++x) {
      if (x < 0 || y < 0 || x >= pair.decoded->width || y >= pair.decoded->height) continue;
      const double difference = static_cast<double>(pair.decoded->at(x, y)) - pair.original.at(x, y);
      sum += difference * difference;
      ++count;
    }
  }
  return count > 0 ? sum / count : unseen_squares;
}

std::optional<double> best_squares(const std::vector<const Pair*>& pairs, const Vec3& point) {
  std::optional<double> best;
  for (const Pair* pair : pairs) {
    Vec2 pixel;
    double depth = 0;
    if (!world::project(*pair->frame, point, pixel, depth) || !world::sees(*pair->frame, point)) continue;
    const double squares = squares_around(*pair, pixel);
    if (!best || squares < *best) best = squares;
  }
  return best;
}

bool near(const Pair& pair, const world::PlantedFeature& feature) {
  const Vec3& low = pair.frame->low;
  const Vec3& high = pair.frame->high;
  const double r = feature.radius_m;
  return feature.x > low.x() - r && feature.x < high.x() + r && feature.y > low.y() - r && feature.y < high.y() + r;
}

bool has_height(const std::vector<StripErrors>& strips, const world::HeightGrid& truth, const Vec3& point) {
  const auto i = static_cast<std::int32_t>(std::lround((point.x() - truth.x0) / truth.cell));
  const auto j = static_cast<std::int32_t>(std::lround((truth.y0 - point.y()) / truth.cell));
  if (i < 0 || j < 0 || i >= truth.height_m.width || j >= truth.height_m.height) return false;
  return std::isfinite(error_at(strips, i, j).first);
}

/// Sums over rectangles of a map, of what it has of values and of how many there are.
class RectangleSums {
 public:
  explicit RectangleSums(const host::Raster<double>& map)
      : width_(static_cast<std::size_t>(map.width) + 1), sums_(width_ * (static_cast<std::size_t>(map.height) + 1)) {
    for (std::size_t j = 1; j * width_ < sums_.size(); ++j) {
      Sum row;
      for (std::size_t i = 1; i < width_; ++i) {
        const double value = map.samples[(j - 1) * (width_ - 1) + i - 1];
        if (std::isfinite(value)) row = {row.values + value, row.count + 1};
        const Sum& above = sums_[(j - 1) * width_ + i];
        sums_[j * width_ + i] = {row.values + above.values, row.count + above.count};
      }
    }
  }
  /// Over columns [i0, i1) and rows [j0, j1).
  [[nodiscard]] double mean(std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1) const {
    const Sum &a = sums_[j0 * width_ + i0], &b = sums_[j0 * width_ + i1], &c = sums_[j1 * width_ + i0],
              &d = sums_[j1 * width_ + i1];
    return (d.values - b.values - c.values + a.values) / (d.count - b.count - c.count + a.count);
  }

 private:
  struct Sum {
    double values = 0, count = 0;
  };
  std::size_t width_;
  std::vector<Sum> sums_;
};

/// `errors` in percent of the flying height; `reach` cells each way.
void score_relief(const host::Raster<double>& errors, std::int32_t reach, GroundValue& value) {
  const RectangleSums sums(errors);
  std::vector<double> deviations;
  for (std::int32_t j = 0; j < errors.height; ++j) {
    for (std::int32_t i = 0; i < errors.width; ++i) {
      const double error = errors.at(i, j);
      if (!std::isfinite(error)) continue;
      const auto low = [reach](std::int32_t at) { return static_cast<std::size_t>(std::max(at - reach, 0)); };
      const auto high = [reach](std::int32_t at, std::int32_t extent) {
        return static_cast<std::size_t>(std::min(at + reach + 1, extent));
      };
      const double mean = sums.mean(low(i), high(i, errors.width), low(j), high(j, errors.height));
      deviations.push_back(std::fabs(error - mean));
      value.known_relief += deviations.back() <= known_relief_percent;
    }
  }
  if (deviations.empty()) return;
  value.relief_median_percent = host::percentile(deviations, 0.5);
  value.relief_p95_percent = host::percentile(deviations, 0.95);
}

/// `errors` in percent of the flying height.
double half_right_within(const host::Raster<double>& errors, std::size_t cells) {
  std::vector<double> sizes;
  for (const double error : errors.samples) {
    if (std::isfinite(error)) sizes.push_back(std::fabs(error));
  }
  const std::size_t half = (cells + 1) / 2;
  if (cells == 0 || sizes.size() < half) return unknown;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(half - 1);
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

}  // namespace

GroundValue score_ground(const world::HeightGrid& truth, const std::vector<StripErrors>& strips) {
  GroundValue value;
  host::Raster<double> errors(truth.height_m.width, truth.height_m.height, unknown);
  double reach = 0;
  for (std::int32_t j = 0; j < truth.height_m.height; ++j) {
    for (std::int32_t i = 0; i < truth.height_m.width; ++i) {
      if (!std::isfinite(truth.height_m.at(i, j))) continue;
      ++value.cells;
      const auto [error, flying_height] = error_at(strips, i, j);
      if (!std::isfinite(error)) continue;
      ++value.covered;
      value.known += std::fabs(error) * 100 <= known_height_percent * flying_height;
      errors.at(i, j) = error * 100 / flying_height;
      reach = relief_window * flying_height / truth.cell;
    }
  }
  value.half_percent = half_right_within(errors, value.cells);
  score_relief(errors, static_cast<std::int32_t>(std::lround(reach)), value);
  return value;
}

void score_features(const std::vector<world::PlantedFeature>& features, const intake::Flight& flight,
                    const world::HeightGrid& truth, const std::vector<StripErrors>& strips, TrueFrames& frames,
                    const fs::path& images, GroundValue& value) {
  const std::vector<Pair> all = image_pairs(flight, frames, images);
  for (const world::PlantedFeature& feature : features) {
    if (!counts(feature)) continue;
    const std::vector<Vec3> disc = disc_of(feature, truth);
    if (disc.empty()) continue;
    ++value.features;
    std::vector<const Pair*> pairs;
    for (const Pair& pair : all) {
      if (near(pair, feature)) pairs.push_back(&pair);
    }
    std::size_t shown = 0, heights = 0;
    double squares = 0;
    for (const Vec3& point : disc) {
      if (const auto best = best_squares(pairs, point)) {
        ++shown;
        squares += *best;
      }
      heights += has_height(strips, truth, point);
    }
    const auto points = static_cast<double>(disc.size());
    const auto missing = points - static_cast<double>(shown);
    value.feature_squares += (squares + missing * unseen_squares) / points;
    const bool enough = static_cast<double>(shown) >= feature_disc_share * points &&
                        static_cast<double>(heights) >= feature_disc_share * points;
    if (!enough) continue;
    const double db = 10 * std::log10(full_scale_squared * static_cast<double>(shown) / squares);
    value.seen += db >= seen_psnr_db;
    value.seen_well += db >= seen_well_psnr_db;
  }
}

std::vector<world::PlantedFeature> planted_features(const fs::path& truth, const world::HeightGrid& heights) {
  const fs::path file = truth.parent_path() / "scenario.ini";
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  const world::Scenario scenario = world::load_scenario(file.string(), {});
  const double width = heights.cell * (heights.height_m.width - 1),
               height = heights.cell * (heights.height_m.height - 1);
  return world::Ground(scenario.world).features({heights.x0, heights.y0 - height, heights.x0 + width, heights.y0});
}

std::map<std::string, double> ground_value_summary(const GroundValue& value) {
  const double squares = value.features > 0 ? value.feature_squares / static_cast<double>(value.features) : unknown;
  return {{"terrain_coverage", value.coverage()},
          {"terrain_known_share", value.known_share()},
          {"terrain_half_percent", value.half_percent},
          {"relief_known_share", value.known_relief_share()},
          {"relief_median_percent", value.relief_median_percent},
          {"relief_p95_percent", value.relief_p95_percent},
          {"features", value.features > 0 ? static_cast<double>(value.features) : unknown},
          {"feature_share", value.feature_share()},
          {"feature_well_share", value.feature_well_share()},
          {"feature_psnr_db", 10 * std::log10(full_scale_squared / squares)}};
}

}  // namespace ilp::score
