#include "sim/tools/richness/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp::richness {
namespace {

constexpr std::size_t cue_count = richness_cue_count + 1;

struct Sample {
  std::array<double, cue_count> x{};
  double y = 0;
  double weight = 0;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double two_digits(double value) {
  if (!(value > 0)) return 0;
  double unit = 1;
  while (value / unit >= 100) unit *= 10;
  while (value / unit < 10) unit /= 10;
  const double rounded = std::floor(value / unit + 0.5);
  // Dividing by whole numbers gives the nearest to a decimal fraction.
  return unit >= 1 ? rounded * unit : rounded / std::floor(1 / unit + 0.5);
}

void fit_halves(const std::vector<EvaluatedImage>& images, RichnessParams& params) {
  for (const NamedCue& cue : named_cues()) {
    std::array<std::vector<double>, 2> values;
    for (const EvaluatedImage& image : images) {
      values[image.label == Label::interesting ? 1 : 0].push_back(image.cues.*cue.cue);
    }
    if (values[0].empty() || values[1].empty()) continue;
    const double half = std::sqrt(median(values[0]) * median(values[1]));
    if (half > 0) (params.*cue.scale).half = two_digits(half);
  }
}

std::vector<Sample> samples_of(const std::vector<EvaluatedImage>& images, const RichnessParams& params) {
  std::array<double, 6> of_kind{};
  double plain = 0;
  for (const EvaluatedImage& image : images) {
    if (image.label == Label::interesting) of_kind[static_cast<std::size_t>(image.feature)] += 1;
    if (image.label == Label::plain) plain += 1;
  }
  const auto kinds = static_cast<double>(planted_kinds().size());
  std::vector<Sample> samples;
  for (const EvaluatedImage& image : images) {
    Sample sample;
    for (std::size_t c = 0; c < cue_count; ++c) {
      const NamedCue& cue = named_cues()[c];
      const double value = image.cues.*cue.cue;
      sample.x[c] = value / (value + (params.*cue.scale).half);
    }
    sample.y = image.label == Label::interesting ? 1 : 0;
    sample.weight = 0.5 / (sample.y > 0 ? kinds * of_kind[static_cast<std::size_t>(image.feature)] : plain);
    samples.push_back(sample);
  }
  return samples;
}

std::array<double, cue_count> regress(const std::vector<Sample>& samples) {
  constexpr int iterations = 4000;
  constexpr double rate = 4;
  constexpr double decay = 2e-4;
  std::array<double, cue_count> mean{};
  for (const Sample& sample : samples) {
    for (std::size_t c = 0; c < cue_count; ++c) mean[c] += sample.weight * sample.x[c];
  }
  std::array<double, cue_count> weight{};
  double offset = 0;
  for (int k = 0; k < iterations; ++k) {
    std::array<double, cue_count> gradient{};
    double gradient_offset = 0;
    for (const Sample& sample : samples) {
      double score = offset;
      for (std::size_t c = 0; c < cue_count; ++c) score += weight[c] * (sample.x[c] - mean[c]);
      const double error = sample.weight * (1 / (1 + det_exp(-score)) - sample.y);
      for (std::size_t c = 0; c < cue_count; ++c) gradient[c] += error * (sample.x[c] - mean[c]);
      gradient_offset += error;
    }
    for (std::size_t c = 0; c < cue_count; ++c) {
      weight[c] = std::max(0.0, weight[c] - rate * (gradient[c] + decay * weight[c]));
    }
    offset -= rate * gradient_offset;
  }
  return weight;
}

}  // namespace

RichnessParams fit_richness(std::vector<EvaluatedImage> images, double least_weight) {
  std::erase_if(images,
                [](const EvaluatedImage& image) { return image.label == Label::neither || !image.cues.has_terrain; });
  RichnessParams params;
  fit_halves(images, params);
  // Novelty depends on the halves of the others, and theirs on nothing.
  score_again(params, images);
  fit_halves(images, params);
  const std::array<double, cue_count> weight = regress(samples_of(images, params));
  double sum = 0;
  for (const double w : weight) sum += w;
  for (std::size_t c = 0; c < cue_count; ++c) {
    const double share = sum > 0 ? 10 * weight[c] / sum : 1;
    (params.*named_cues()[c].scale).weight = two_digits(std::max(least_weight, share));
  }
  return params;
}

}  // namespace ilp::richness
