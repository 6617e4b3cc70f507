#include "fsw/vision/terrain/richness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/base/argument.hpp"
#include "fsw/vision/terrain/richness_cues.hpp"

namespace ilp {
namespace {

// Deviations below this share of a squashed cue's range are no novelty, however uniform the flight has been.
constexpr double least_deviation = 0.05;
// A smaller newly seen part has no cues: index 0.
constexpr std::uint32_t least_seen_pixels = 256;
constexpr std::uint32_t images_before_novelty = 3;
constexpr std::size_t first_terrain_cue = 4;
// An unknown terrain cue counts as on plain ground, because a failed match makes the ground no more interesting.
constexpr double unknown_cue = 0.2;

struct ScaledCue {
  double value;
  CueScale scale;
  [[nodiscard]] double squashed() const { return value / (value + scale.half); }
};

using ScaledCues = std::array<ScaledCue, richness_cue_count>;

ScaledCues scaled(const RichnessCues& c, const RichnessParams& p) {
  return {{{c.gradient_fine, p.gradient_fine},
           {c.gradient_coarse, p.gradient_coarse},
           {c.entropy, p.entropy},
           {c.contrast, p.contrast},
           {c.relief, p.relief},
           {c.slope_steep, p.slope_steep},
           {c.slope_excess, p.slope_excess},
           {c.roughness_fine, p.roughness_fine},
           {c.roughness_coarse, p.roughness_coarse},
           {c.curvature, p.curvature}}};
}

std::size_t countable(const RichnessCues& cues) {
  return cues.has_terrain ? richness_cue_count : first_terrain_cue;
}

bool sensible(const CueScale& s) {
  return std::isfinite(s.half) && std::isfinite(s.weight) && s.half > 0 && s.weight >= 0;
}

bool same_halves(const ScaledCues& cues, const RichnessHistory& history) {
  for (std::size_t i = 0; i < richness_cue_count; ++i) {
    if (cues[i].scale.half != history.halves[i]) return false;
  }
  return true;
}

/// In standard deviations; one deviation while the history is too short.
double novelty_of(const ScaledCues& cues, std::size_t count, const RichnessHistory& history) {
  if (history.count < images_before_novelty || !same_halves(cues, history)) return 1;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double deviation = cues[i].squashed() - history.mean[i];
    sum += deviation * deviation / (history.variance[i] + least_deviation * least_deviation);
  }
  return std::sqrt(sum / static_cast<double>(count));
}

Status check(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
             ImageView<const float> sigma, MaskView mask, const RichnessParams& params, const RichnessCues& cues) {
  const auto fits = [&](const auto& view) { return view.width == camera.width && view.height == camera.height; };
  if (!fits(image) || !fits(inverse_depth) || !fits(sigma) || !fits(mask) || image.empty()) {
    return out_of_range(Argument::image_size, image.width);
  }
  if (camera.width > limits::max_image_width || camera.height > limits::max_image_height) {
    return {StatusCode::image_too_large, camera.width, camera.height};
  }
  for (const ScaledCue& cue : scaled(cues, params)) {
    if (!sensible(cue.scale)) return out_of_range(Argument::richness_parameters);
  }
  return sensible(params.novelty) ? Status{} : out_of_range(Argument::richness_parameters);
}

std::uint32_t count_inside(MaskView mask) {
  std::uint32_t inside = 0;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    const std::uint8_t* row = mask.row(y);
    for (std::int32_t x = 0; x < mask.width; ++x) inside += row[x] != 0 ? 1 : 0;
  }
  return inside;
}

}  // namespace

void begin_richness(RichnessWorkspace& workspace, RichnessCues& cues) {
  workspace.part = 0;
  cues = {};
}

Result<bool> score_richness_slice(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                                  ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                                  const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues,
                                  double& index) {
  index = 0;
  const std::int32_t part = workspace.part++;
  if (part == 0) {
    ILP_TRY(check(camera, image, inverse_depth, sigma, mask, params, cues));
    const std::uint32_t inside = count_inside(mask);
    cues.mask_fraction = inside / static_cast<double>(mask.area());
    if (inside < least_seen_pixels) return false;
  }
  if (part < image_cue_parts) {
    measure_image_cues(part, image, mask, params.noise_grey, workspace, cues);
  } else {
    measure_terrain_cues(part - image_cue_parts, camera, inverse_depth, sigma, mask, workspace, cues);
  }
  if (part + 1 < image_cue_parts + terrain_cue_parts) return true;
  index = richness_index(params, history, cues);
  return false;
}

Status score_richness(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                      ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                      const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues, double& index) {
  begin_richness(workspace, cues);
  return do_all([&] {
    return score_richness_slice(camera, image, inverse_depth, sigma, mask, params, history, workspace, cues, index);
  });
}

double richness_index(const RichnessParams& params, const RichnessHistory& history, RichnessCues& cues) {
  const ScaledCues all = scaled(cues, params);
  const std::size_t count = countable(cues);
  cues.novelty = novelty_of(all, count, history);
  const ScaledCue novelty{cues.novelty, params.novelty};
  double sum = novelty.squashed() * novelty.scale.weight;
  double weights = novelty.scale.weight;
  for (std::size_t i = 0; i < count; ++i) {
    sum += all[i].squashed() * all[i].scale.weight;
    weights += all[i].scale.weight;
  }
  for (std::size_t i = count; i < richness_cue_count; ++i) {
    sum += unknown_cue * all[i].scale.weight;
    weights += all[i].scale.weight;
  }
  return weights > 0 ? sum / weights : 0;
}

void learn(const RichnessCues& cues, const RichnessParams& params, RichnessHistory& history) {
  if (!cues.has_terrain) return;
  const ScaledCues all = scaled(cues, params);
  if (!same_halves(all, history)) {
    history = {};
    for (std::size_t i = 0; i < richness_cue_count; ++i) history.halves[i] = all[i].scale.half;
  }
  if (history.count < std::numeric_limits<std::uint32_t>::max()) ++history.count;
  const std::uint32_t memory = std::max(params.novelty_memory, images_before_novelty);
  const double share = 1.0 / std::min(history.count, memory);
  for (std::size_t i = 0; i < richness_cue_count; ++i) {
    const double deviation = all[i].squashed() - history.mean[i];
    history.mean[i] += share * deviation;
    history.variance[i] += share * (deviation * (all[i].squashed() - history.mean[i]) - history.variance[i]);
  }
}

}  // namespace ilp
