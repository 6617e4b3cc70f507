#include "sim/tools/richness/planted_keyframes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"
#include "fsw/vision/terrain/mask.hpp"
#include "sim/host/status_error.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::richness {

struct StereoScratch {
  StereoWorkspace stereo;
  RectificationPlan plan;
  StereoMatcher matcher;
  Coverage coverage;
  SeenCells seen;
  CoverageWorkspace coverage_workspace;
};

namespace {

struct Range {
  double low, high;
};

/// Draws from ranges; those of the held-out set are wider by a fifth of their length at either end where they may be.
class Draw {
 public:
  Draw(WorldSet set, std::uint64_t seed) : rng_(seed, set == WorldSet::tuning ? 31 : 32), set_(set) {}

  double within(Range tuning, Range held_out) {
    const Range range = set_ == WorldSet::tuning ? tuning : held_out;
    return range.low + (range.high - range.low) * rng_.uniform();
  }
  double within(Range both) { return within(both, both); }
  std::uint64_t seed() { return rng_.next(); }

 private:
  Rng rng_;
  WorldSet set_;
};

void lay_ground(GroundKind ground, Draw& draw, world::WorldParams& w) {
  w.post_spacing_m = 0.25;
  w.longest_wavelength_m = draw.within({120, 200}, {100, 250});
  w.shortest_wavelength_m = 1;
  w.relief_m = draw.within({1, 4}, {0.6, 5});
  w.hurst = draw.within({0.85, 1}, {0.8, 1.05});
  w.albedo_contrast = draw.within({0.3, 0.7}, {0.2, 0.8});
  w.sun_elevation_rad = draw.within({0.5, 1.1}, {0.4, 1.25});
  w.sun_azimuth_rad = draw.within({0, 6.28});
  w.ambient = draw.within({0.2, 0.4}, {0.15, 0.5});
  // Small craters and stones lie on all of it: they are no features.
  w.largest_crater_radius_m = 1.5;
  w.smallest_crater_radius_m = 0.75;
  w.crater_density = draw.within({0, 0.15}, {0, 0.25});
  w.largest_rock_radius_m = 0.7;
  w.smallest_rock_radius_m = 0.3;
  w.rock_density = draw.within({0, 0.2}, {0, 0.3});
  switch (ground) {
    case GroundKind::dunes:
      w.dune_height_m = draw.within({0.2, 0.5}, {0.15, 0.6});
      w.dune_wavelength_m = draw.within({8, 14}, {6, 18});
      w.dune_direction_rad = draw.within({0, 6.28});
      break;
    case GroundKind::hills:
      w.longest_wavelength_m = draw.within({280, 400}, {250, 450});
      w.relief_m = draw.within({18, 32}, {15, 40});
      w.hurst = draw.within({1.15, 1.3}, {1.1, 1.4});
      break;
    case GroundKind::hazy:
      w.ambient = draw.within({0.5, 0.7}, {0.45, 0.8});
      break;
    case GroundKind::stark:
      w.albedo_contrast = draw.within({0.85, 1}, {0.8, 1});
      w.sun_elevation_rad = draw.within({0.25, 0.4}, {0.2, 0.4});
      break;
    default:
      break;
  }
}

void plant(world::FeatureKind feature, Draw& draw, world::WorldParams& w) {
  switch (feature) {
    case world::FeatureKind::crater:
      w.largest_crater_radius_m = draw.within({8, 14}, {6, 17});
      w.smallest_crater_radius_m = 0.5 * w.largest_crater_radius_m;
      w.crater_density = draw.within({0.12, 0.2}, {0.1, 0.22});
      break;
    case world::FeatureKind::outcrop:
      w.outcrop_radius_m = draw.within({8, 14}, {6, 18});
      w.outcrop_density = draw.within({0.2, 0.35}, {0.15, 0.4});
      break;
    case world::FeatureKind::scarp:
      w.relief_m = w.relief_m + draw.within({7, 11}, {6, 13});
      w.hurst = w.hurst + 0.2;
      w.terrace_step_m = w.relief_m * draw.within({0.5, 0.65}, {0.45, 0.7});
      w.terrace_steepness = draw.within({0.8, 0.9}, {0.75, 0.95});
      break;
    case world::FeatureKind::channel:
      w.channel_depth_m = draw.within({1.2, 2.5}, {1, 3});
      w.channel_width_m = draw.within({7, 12}, {6, 15});
      w.channel_spacing_m = draw.within({110, 150}, {90, 170});
      w.channel_direction_rad = draw.within({0.9, 2.2}, {0.7, 2.4});
      break;
    case world::FeatureKind::boulder_field:
      w.largest_rock_radius_m = draw.within({1.6, 2.3}, {1.55, 2.6});
      w.smallest_rock_radius_m = 0.4;
      w.rock_density *= 0.1;
      w.boulder_field_layers = 6;
      w.boulder_field_radius_m = draw.within({10, 18}, {8, 20});
      w.boulder_field_density = draw.within({0.3, 0.45}, {0.25, 0.5});
      w.boulder_field_rock_density = draw.within({0.8, 1}, {0.7, 1});
      break;
    case world::FeatureKind::rock:
      break;
  }
}

/// All lengths of a world that was made for an altitude of 100 m.
void scale_lengths(double factor, world::WorldParams& w) {
  for (double* length :
       {&w.relief_m, &w.longest_wavelength_m, &w.shortest_wavelength_m, &w.post_spacing_m, &w.largest_crater_radius_m,
        &w.smallest_crater_radius_m, &w.largest_rock_radius_m, &w.smallest_rock_radius_m, &w.boulder_field_radius_m,
        &w.outcrop_radius_m, &w.dune_height_m, &w.dune_wavelength_m, &w.channel_depth_m, &w.channel_width_m,
        &w.channel_spacing_m, &w.terrace_step_m}) {
    *length *= factor;
  }
}

struct View {
  world::CameraState state;
  world::RenderedFrame frame;

  [[nodiscard]] RigidTransform cam_from_world() const { return {state.rotation, -(state.rotation * state.centre)}; }
};

struct DepthMap {
  host::Raster<float> inverse, sigma;
};

world::CameraState looking_down(double x, double altitude_m, Rng& rng) {
  constexpr double jitter_rad = 0.02;
  constexpr double jitter_height = 0.02;
  const auto jitter = [&] { return 2 * rng.uniform() - 1; };
  world::CameraState state;
  Mat3 down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const Vec3 turn(jitter_rad * jitter(), jitter_rad * jitter(), jitter_rad * jitter());
  state.rotation = rotation_from_vector(turn) * down;
  state.centre = Vec3(x, 0.02 * altitude_m * jitter(), altitude_m * (1 + jitter_height * jitter()));
  return state;
}

DepthMap true_depth(const View& view) {
  DepthMap map{view.frame.depth_m, view.frame.depth_m};
  for (float& value : map.inverse.samples) value = 1 / value;
  std::fill(map.sigma.samples.begin(), map.sigma.samples.end(), 1e-6F);
  return map;
}

DepthMap match(const PlantedWorld& planted, const View& a, const View& b, StereoScratch& s) {
  const CameraModel& camera = planted.camera;
  const auto [nearest, farthest] = std::minmax_element(a.frame.depth_m.samples.begin(), a.frame.depth_m.samples.end());
  const DepthRange range{static_cast<double>(*nearest) / 1.1, static_cast<double>(*farthest) * 1.1};
  host::require(plan_panels(camera, a.cam_from_world(), b.cam_from_world(), range, RectificationParams{}, s.plan),
                "rectification");
  DepthMap map{host::Raster<float>(camera.width, camera.height), host::Raster<float>(camera.width, camera.height)};
  host::Raster<std::uint64_t> supported(supported_words(camera.width), camera.height);
  for (std::size_t p = 0; p < s.plan.count; ++p) {
    const RectifiedPair& pair = s.plan.panels[p].pair;
    host::Raster<std::uint8_t> left(pair.width, pair.height), right(pair.width, pair.height);
    host::Raster<std::uint8_t> left_valid(pair.width, pair.height), right_valid(pair.width, pair.height);
    host::Raster<float> disparity(pair.width, pair.height), sigma(pair.width, pair.height);
    host::require(
        resample_rows(pair, Side::left, camera, a.frame.grey.view(), 0, pair.height, left.view(), left_valid.view()),
        "rectification");
    host::require(
        resample_rows(pair, Side::right, camera, b.frame.grey.view(), 0, pair.height, right.view(), right_valid.view()),
        "rectification");
    const auto constant = [](auto& image) {
      return static_cast<const std::remove_reference_t<decltype(image)>&>(image).view();
    };
    host::require(s.matcher.begin(constant(left), constant(right), constant(left_valid), constant(right_valid),
                                  s.plan.panels[p].range, StereoParams{}, s.stereo, {disparity.view(), sigma.view()}),
                  "stereo");
    host::require(do_all([&] { return s.matcher.step(pair.height); }), "stereo");
    host::require(depth_rows(pair, camera, s.matcher.result(), 0, camera.height,
                             {map.inverse.view(), map.sigma.view(), supported.view()}),
                  "depth");
  }
  // As the flight's scorer: a supported depth has no relief of its own.
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const std::uint64_t word = supported.at(x / supported_bits, y);
      if ((word >> (x % supported_bits) & 1U) != 0) map.sigma.at(x, y) = 0;
    }
  }
  return map;
}

/// Depth as the scorer reads it from the store: codes inside the mask.
void code_and_decode(double focal_px, double baseline, DepthMap& map, ImageView<const std::uint8_t> mask) {
  constexpr double steps_per_px = 16;
  const auto inverse = static_cast<const host::Raster<float>&>(map.inverse).view();
  const auto sigma = static_cast<const host::Raster<float>&>(map.sigma).view();
  DepthCoding coding;
  host::require(choose_depth_coding(inverse, sigma, mask, focal_px, baseline, steps_per_px, coding), "depth coding");
  host::Raster<std::uint16_t> codes(map.inverse.width, map.inverse.height);
  host::require(encode_depth(inverse, sigma, mask, coding, codes.view()), "depth coding");
  host::require(decode_depth(static_cast<const host::Raster<std::uint16_t>&>(codes).view(), coding, map.inverse.view()),
                "depth coding");
  for (std::size_t i = 0; i < codes.samples.size(); ++i) {
    if (codes.samples[i] == 0) map.sigma.samples[i] = 0;
  }
}

Vec3 ground_at(const CameraModel& camera, const View& view, int x, int y) {
  const Vec2 n = normalised_from_pixel(camera, Vec2(x, y));
  const double depth = static_cast<double>(view.frame.depth_m.at(x, y));
  return view.state.rotation.transpose() * Vec3(n.x() * depth, n.y() * depth, depth) + view.state.centre;
}

/// How far ground is near a feature, in radii.
double nearness(world::FeatureKind kind) {
  switch (kind) {
    case world::FeatureKind::crater:
      return world::Crater::reach;
    case world::FeatureKind::scarp:
      return 4;
    default:
      return 1.1;
  }
}

/// What is planted around a place, as far as it matters for the truth.
class PlantedTruth {
 public:
  PlantedTruth(const PlantedWorld& planted, const world::Terrain& terrain, const world::Rectangle& area)
      : planted_(planted), near_(nearness(planted.feature)), px_m_(planted.altitude_m / planted.camera.fx) {
    // Craters reach farthest, and of scarps nothing is longer than the spacing of their points.
    const double margin = planted.feature == world::FeatureKind::crater ? 1.5 * planted.world.largest_crater_radius_m
                                                                        : 0.1 * planted.altitude_m;
    for (const world::PlantedFeature& feature :
         terrain.features({area.x0 - margin, area.y0 - margin, area.x1 + margin, area.y1 + margin})) {
      const bool boulder = planted.feature == world::FeatureKind::boulder_field &&
                           feature.kind == world::FeatureKind::rock &&
                           2 * feature.radius_m >= smallest_boulder_px * px_m_;
      const bool background =
          feature.kind == world::FeatureKind::crater && feature.radius_m < 1.01 * planted.background_crater_m;
      if (boulder) boulders_.push_back(feature);
      if (feature.kind == planted.feature && !background) features_.push_back(feature);
    }
  }

  [[nodiscard]] bool is_near(const Vec2& place) const {
    return any(features_, place, near_, [](const world::PlantedFeature&) { return true; }) || by_a_boulder(place);
  }
  [[nodiscard]] bool is_on(const Vec2& place) const {
    const bool on =
        any(features_, place, 1, [&](const world::PlantedFeature& feature) { return large_enough(feature); });
    return on && (planted_.feature != world::FeatureKind::boulder_field || by_a_boulder(place));
  }

 private:
  template <typename Wanted>
  static bool any(const std::vector<world::PlantedFeature>& features, const Vec2& place, double radii, Wanted wanted) {
    return std::any_of(features.begin(), features.end(), [&](const world::PlantedFeature& feature) {
      const double reach = radii * feature.radius_m;
      return (place - Vec2(feature.x, feature.y)).squaredNorm() < reach * reach && wanted(feature);
    });
  }
  [[nodiscard]] bool by_a_boulder(const Vec2& place) const {
    return any(boulders_, place, 2, [](const world::PlantedFeature&) { return true; });
  }
  [[nodiscard]] bool large_enough(const world::PlantedFeature& feature) const {
    return (feature.kind == world::FeatureKind::scarp || 2 * feature.radius_m >= smallest_feature_px * px_m_) &&
           feature.relief_m >= smallest_relief * planted_.altitude_m;
  }

  const PlantedWorld& planted_;
  double near_, px_m_;
  std::vector<world::PlantedFeature> features_, boulders_;
};

/// feature_share and near_share, from a pixel in every square of `step`.
void measure_truth(const PlantedWorld& planted, const world::Terrain& terrain, const View& view,
                   PlantedKeyframe& keyframe) {
  constexpr int step = 3;
  std::vector<Vec2> places;
  world::Rectangle area{1e30, 1e30, -1e30, -1e30};
  for (int y = 1; y < keyframe.mask.height; y += step) {
    for (int x = 1; x < keyframe.mask.width; x += step) {
      if (keyframe.mask.at(x, y) == 0) continue;
      const Vec3 p = ground_at(planted.camera, view, x, y);
      places.emplace_back(p.x(), p.y());
      area = {std::min(area.x0, p.x()), std::min(area.y0, p.y()), std::max(area.x1, p.x()), std::max(area.y1, p.y())};
    }
  }
  if (places.empty()) return;
  const PlantedTruth truth(planted, terrain, area);
  const auto share = [&](auto&& holds) {
    return static_cast<double>(std::count_if(places.begin(), places.end(), holds)) / static_cast<double>(places.size());
  };
  keyframe.feature_share = share([&](const Vec2& place) { return truth.is_on(place); });
  keyframe.near_share = share([&](const Vec2& place) { return truth.is_near(place); });
}

/// Ground within 0.3 x 0.6 of what the base height sees, around `x`.
void keep_patch(const PlantedWorld& planted, const View& view, double x, host::Raster<std::uint8_t>& mask) {
  const CameraModel& camera = planted.camera;
  const double half_x = 0.15 * planted.altitude_m * camera.width / camera.fx;
  const double half_y = 0.3 * planted.altitude_m * camera.height / camera.fy;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vec3 p = ground_at(camera, view, u, v);
      if (std::fabs(p.x() - x) > half_x || std::fabs(p.y()) > half_y) mask.at(u, v) = 0;
    }
  }
}

class Strip {
 public:
  Strip(const PlantedWorld& planted, const Viewing& viewing, StereoScratch& scratch)
      : planted_(planted),
        viewing_(viewing),
        scratch_(scratch),
        terrain_(planted.world),
        renderer_(terrain_, planted.camera, effects(), planted.seed),
        altitude_m_(planted.altitude_m * viewing.height),
        advance_m_((1 - viewing.overlap) * altitude_m_ * planted.camera.width / planted.camera.fx) {}

  std::vector<PlantedKeyframe> fly() {
    std::vector<PlantedKeyframe> keyframes;
    if (viewing_.same_ground) {
      // Places do not depend on the height.
      const double apart_m = 0.4 * planted_.altitude_m * planted_.camera.width / planted_.camera.fx;
      for (int k = 0; k < viewing_.keyframes; ++k) {
        const double x = k * apart_m;
        host::require(clear_coverage(planted_.camera.width, planted_.camera.height, scratch_.coverage), "mask");
        keyframes.push_back(keyframe(look(x - 0.5 * advance_m_, 2 * k), look(x + 0.5 * advance_m_, 2 * k + 1), &x));
      }
      return keyframes;
    }
    host::require(clear_coverage(planted_.camera.width, planted_.camera.height, scratch_.coverage), "mask");
    View view = look(0, 0);
    for (int k = 0; k < viewing_.keyframes; ++k) {
      View next = look((k + 1) * advance_m_, k + 1);
      keyframes.push_back(keyframe(view, next, nullptr));
      view = std::move(next);
    }
    return keyframes;
  }

 private:
  [[nodiscard]] world::CameraEffects effects() const {
    world::CameraEffects effects = planted_.effects;
    effects.gain *= viewing_.gain;
    effects.read_noise_grey += viewing_.read_noise;
    effects.haze = std::min(1.0, effects.haze + viewing_.haze);
    return effects;
  }

  View look(double x, int index) {
    Rng rng(planted_.seed * 1000 + static_cast<std::uint64_t>(index), 33);
    View view;
    view.state = looking_down(x, altitude_m_, rng);
    world::CameraMotion motion;
    motion.state = view.state;
    renderer_.render(motion, index, view.frame);
    for (std::uint8_t& grey : view.frame.grey.samples) {
      grey = static_cast<std::uint8_t>(std::clamp(grey + viewing_.offset_grey, 0.0, 255.0));
    }
    return view;
  }

  PlantedKeyframe keyframe(const View& view, const View& next, const double* patch_x) {
    const CameraModel& camera = planted_.camera;
    DepthMap map = viewing_.true_depth ? true_depth(view) : match(planted_, view, next, scratch_);
    PlantedKeyframe keyframe;
    keyframe.camera = camera;
    keyframe.mask = host::Raster<std::uint8_t>(camera.width, camera.height);
    const auto sigma = static_cast<const host::Raster<float>&>(map.sigma).view();
    const auto inverse_depth = static_cast<const host::Raster<float>&>(map.inverse).view();
    host::require(seen_cells(inverse_depth, sigma, camera.fx, 1, scratch_.seen), "mask");
    // At one altitude no ground is seen much better than before.
    constexpr std::int32_t never_finer = sampling_levels;
    MaskCounts counts;
    host::require(newly_seen_mask(sigma, scratch_.coverage, scratch_.seen, never_finer, keyframe.mask.view(), counts),
                  "mask");
    const PairGround ground{inverse_depth, sigma, keyframe.mask.view(), scratch_.seen};
    host::require(carry_coverage(camera, ground, compose(next.cam_from_world(), inverse(view.cam_from_world())),
                                 scratch_.coverage_workspace, scratch_.coverage),
                  "mask");
    if (patch_x != nullptr) keep_patch(planted_, view, *patch_x, keyframe.mask);
    const auto inside = std::count(keyframe.mask.samples.begin(), keyframe.mask.samples.end(), std::uint8_t{255});
    keyframe.newly_seen = static_cast<double>(inside) / static_cast<double>(keyframe.mask.samples.size());
    code_and_decode(camera.fx, (next.state.centre - view.state.centre).norm(), map,
                    static_cast<const host::Raster<std::uint8_t>&>(keyframe.mask).view());
    measure_truth(planted_, terrain_, view, keyframe);
    keyframe.grey = view.frame.grey;
    keyframe.inverse_depth = std::move(map.inverse);
    keyframe.sigma = std::move(map.sigma);
    return keyframe;
  }

  const PlantedWorld& planted_;
  const Viewing& viewing_;
  StereoScratch& scratch_;
  world::Terrain terrain_;
  world::Renderer renderer_;
  double altitude_m_, advance_m_;
};

}  // namespace

std::string_view name_of(GroundKind ground) {
  constexpr std::array<std::string_view, 5> names = {"plains", "dunes", "hills", "hazy", "stark"};
  return names[static_cast<std::size_t>(ground)];
}

std::span<const world::FeatureKind> planted_kinds() {
  static constexpr std::array kinds = {world::FeatureKind::crater, world::FeatureKind::outcrop,
                                       world::FeatureKind::scarp, world::FeatureKind::channel,
                                       world::FeatureKind::boulder_field};
  return kinds;
}

std::string_view name_of(world::FeatureKind feature) {
  constexpr std::array<std::string_view, 6> names = {"crater", "boulder field", "rock", "channel", "scarp", "outcrop"};
  return names[static_cast<std::size_t>(feature)];
}

PlantedWorld planted_world(WorldSet set, GroundKind ground, world::FeatureKind feature, std::uint64_t seed) {
  PlantedWorld planted;
  planted.set = set;
  planted.ground = ground;
  planted.feature = feature;
  planted.seed = seed;
  Draw draw(set, mix64(seed * 64 + static_cast<std::uint64_t>(ground) * 8 + static_cast<std::uint64_t>(feature)));
  world::WorldParams& w = planted.world;
  w.seed = draw.seed();
  lay_ground(ground, draw, w);
  planted.background_crater_m = w.largest_crater_radius_m;
  plant(feature, draw, w);

  planted.effects = world::realistic_effects();
  planted.effects.gain = draw.within({0.7, 1.4}, {0.6, 1.6});
  planted.effects.read_noise_grey = draw.within({0.5, 1.5}, {0.5, 2});
  planted.effects.haze = draw.within({0, 0.15}, {0, 0.2});
  if (ground == GroundKind::hazy) {
    planted.effects.haze = draw.within({0.3, 0.45}, {0.25, 0.5});
    planted.effects.read_noise_grey = draw.within({1, 2}, {1, 2.2});
  }

  CameraModel& camera = planted.camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = draw.within({275, 275}, {250, 310});
  camera.cx = 159.5;
  camera.cy = 119.5;
  camera.k1 = draw.within({0, 0}, {-0.1, 0.05});
  planted.altitude_m = draw.within({100, 100}, {70, 300});
  planted.background_crater_m *= planted.altitude_m / 100;
  scale_lengths(planted.altitude_m / 100, w);
  return planted;
}

void StereoScratchDeleter::operator()(StereoScratch* scratch) const {
  delete scratch;
}

StereoScratchPointer make_stereo_scratch() {
  return StereoScratchPointer(new StereoScratch);
}

std::vector<PlantedKeyframe> planted_keyframes(const PlantedWorld& planted, const Viewing& viewing,
                                               StereoScratch& scratch) {
  return Strip(planted, viewing, scratch).fly();
}

}  // namespace ilp::richness
