#include "sim/tools/richness/evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "fsw/base/math.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::richness {
namespace {

constexpr std::size_t grounds = static_cast<std::size_t>(GroundKind::count);

std::vector<EvaluatedImage> evaluate_world(const PlantedWorld& planted, std::size_t number, const Viewing& viewing,
                                           const RichnessParams& params, bool with_depth) {
  const StereoScratchPointer scratch = make_stereo_scratch();
  const auto workspace = std::make_unique<RichnessWorkspace>();
  RichnessHistory history;
  std::vector<EvaluatedImage> images;
  for (const PlantedKeyframe& keyframe : planted_keyframes(planted, viewing, *scratch)) {
    EvaluatedImage image;
    image.set = planted.set;
    image.ground = planted.ground;
    image.feature = planted.feature;
    image.seed = planted.seed;
    image.world = number;
    image.keyframe = static_cast<int>(images.size());
    image.label = keyframe.label();
    image.feature_share = keyframe.feature_share;
    const host::Raster<float> no_depth(keyframe.camera.width, keyframe.camera.height);
    host::require(score_richness(keyframe.camera, keyframe.grey.view(), keyframe.inverse_depth.view(),
                                 with_depth ? keyframe.sigma.view() : no_depth.view(), keyframe.mask.view(), params,
                                 history, *workspace, image.cues, image.index),
                  "richness");
    learn(image.cues, params, history);
    images.push_back(image);
  }
  return images;
}

std::string line(const std::string& name, const std::vector<ScoredImage>& images) {
  const Auc auc = area_under_roc(images);
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%-22s %11zu %6zu   %.3f  %.3f to %.3f\n", name.c_str(), auc.interesting,
                auc.plain, auc.value, auc.low, auc.high);
  return text.data();
}

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

std::size_t WorldRange::worlds() const {
  return seeds * grounds * planted_kinds().size();
}

PlantedWorld WorldRange::world(std::size_t number) const {
  const std::size_t kinds = planted_kinds().size();
  return planted_world(set, static_cast<GroundKind>(number % grounds), planted_kinds()[number / grounds % kinds],
                       first_seed + number / (grounds * kinds));
}

std::vector<EvaluatedImage> evaluate(const WorldRange& range, const Viewing& viewing, const RichnessParams& params,
                                     std::size_t threads, bool with_depth) {
  std::vector<std::vector<EvaluatedImage>> worlds(range.worlds());
  host::for_each_parallel(
      worlds.size(), [&](std::size_t k) { worlds[k] = evaluate_world(range.world(k), k, viewing, params, with_depth); },
      threads);
  std::vector<EvaluatedImage> all;
  for (const auto& world : worlds) all.insert(all.end(), world.begin(), world.end());
  return all;
}

void score_again(const RichnessParams& params, std::vector<EvaluatedImage>& images) {
  RichnessHistory history;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (i > 0 && images[i].world != images[i - 1].world) history = {};
    images[i].index = richness_index(params, history, images[i].cues);
    learn(images[i].cues, params, history);
  }
}

std::vector<ScoredImage> scored(const std::vector<EvaluatedImage>& images, const Choice& interesting,
                                const Choice& plain) {
  std::vector<ScoredImage> chosen;
  for (const EvaluatedImage& image : images) {
    const bool shows = image.label == Label::interesting;
    if (image.label == Label::neither || !(shows ? interesting : plain)(image)) continue;
    chosen.push_back({image.index, shows, image.world});
  }
  return chosen;
}

std::vector<ScoredImage> scored(const std::vector<EvaluatedImage>& images) {
  const Choice all = [](const EvaluatedImage&) { return true; };
  return scored(images, all, all);
}

std::string auc_table(const std::vector<EvaluatedImage>& images) {
  std::string table = "                       interesting  plain   AUC    95 % interval\n";
  const Choice all = [](const EvaluatedImage&) { return true; };
  for (std::size_t g = 0; g < grounds; ++g) {
    const auto ground = static_cast<GroundKind>(g);
    const Choice here = [&](const EvaluatedImage& image) { return image.ground == ground; };
    table += line("ground: " + std::string(name_of(ground)), scored(images, here, here));
  }
  for (const world::FeatureKind feature : planted_kinds()) {
    const Choice shown = [&](const EvaluatedImage& image) { return image.feature == feature; };
    table += line("feature: " + std::string(name_of(feature)), scored(images, shown, all));
  }
  return table + line("all", scored(images));
}

std::string cue_table(const std::vector<EvaluatedImage>& images) {
  std::string table = "                       interesting  plain   AUC    95 % interval\n";
  for (const NamedCue& cue : named_cues()) {
    std::vector<EvaluatedImage> alone = images;
    for (EvaluatedImage& image : alone) image.index = image.cues.*cue.cue;
    table += line(cue.name, scored(alone));
  }
  return table;
}

std::string csv(const std::vector<EvaluatedImage>& images) {
  std::string text = "set,ground,feature,seed,keyframe,feature_share,label,index,mask_fraction,has_terrain";
  for (const NamedCue& cue : named_cues()) text += std::string(",") + cue.name;
  text += "\n";
  for (const EvaluatedImage& image : images) {
    std::array<char, 256> start{};
    constexpr std::array labels = {"plain", "interesting", "neither"};
    std::snprintf(start.data(), start.size(), "%s,%s,%s,%llu,%d,%.5f,%s,%.6f,%.5f,%d",
                  image.set == WorldSet::tuning ? "tuning" : "held-out", std::string(name_of(image.ground)).c_str(),
                  std::string(name_of(image.feature)).c_str(), static_cast<unsigned long long>(image.seed),
                  image.keyframe, image.feature_share, labels[static_cast<std::size_t>(image.label)], image.index,
                  image.cues.mask_fraction, image.cues.has_terrain ? 1 : 0);
    text += start.data();
    for (const NamedCue& cue : named_cues()) {
      std::array<char, 32> value{};
      std::snprintf(value.data(), value.size(), ",%.6g", image.cues.*cue.cue);
      text += value.data();
    }
    text += "\n";
  }
  return text;
}

std::span<const NamedCue> named_cues() {
  static constexpr std::array<NamedCue, richness_cue_count + 1> cues = {{
      {"gradient_fine", &RichnessCues::gradient_fine, &RichnessParams::gradient_fine},
      {"gradient_coarse", &RichnessCues::gradient_coarse, &RichnessParams::gradient_coarse},
      {"entropy", &RichnessCues::entropy, &RichnessParams::entropy},
      {"contrast", &RichnessCues::contrast, &RichnessParams::contrast},
      {"relief", &RichnessCues::relief, &RichnessParams::relief},
      {"slope_steep", &RichnessCues::slope_steep, &RichnessParams::slope_steep},
      {"slope_excess", &RichnessCues::slope_excess, &RichnessParams::slope_excess},
      {"roughness_fine", &RichnessCues::roughness_fine, &RichnessParams::roughness_fine},
      {"roughness_coarse", &RichnessCues::roughness_coarse, &RichnessParams::roughness_coarse},
      {"curvature", &RichnessCues::curvature, &RichnessParams::curvature},
      {"novelty", &RichnessCues::novelty, &RichnessParams::novelty},
  }};
  return cues;
}

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

std::vector<ViewingChange> viewing_changes() {
  std::vector<ViewingChange> changes;
  const auto add = [&](std::string_view name, auto change) {
    ViewingChange c{name, {}};
    c.viewing.same_ground = true;
    change(c);
    changes.push_back(c);
  };
  add("as it is", [](ViewingChange&) {});
  add("gain 0.5", [](ViewingChange& c) { c.viewing.gain = 0.5; });
  add("gain 2", [](ViewingChange& c) { c.viewing.gain = 2; });
  add("20 grey levels more", [](ViewingChange& c) { c.viewing.offset_grey = 20; });
  add("20 grey levels less", [](ViewingChange& c) { c.viewing.offset_grey = -20; });
  add("height 0.7", [](ViewingChange& c) { c.viewing.height = 0.7; });
  add("height 1.5", [](ViewingChange& c) { c.viewing.height = 1.5; });
  add("read noise + 2", [](ViewingChange& c) { c.viewing.read_noise = 2; });
  add("haze + 0.2", [](ViewingChange& c) { c.viewing.haze = 0.2; });
  add("exact depth", [](ViewingChange& c) { c.viewing.true_depth = true; });
  add("no depth", [](ViewingChange& c) { c.with_depth = false; });
  return changes;
}

std::vector<StabilityRow> stability(const WorldRange& range, const std::vector<ViewingChange>& changes,
                                    const RichnessParams& params, std::size_t threads) {
  std::vector<StabilityRow> rows;
  std::vector<EvaluatedImage> base;
  for (const ViewingChange& change : changes) {
    std::vector<EvaluatedImage> images = evaluate(range, change.viewing, params, threads, change.with_depth);
    if (base.empty()) base = images;
    StabilityRow row;
    row.name = change.name;
    std::vector<double> before;
    std::vector<double> after;
    for (std::size_t i = 0; i < images.size(); ++i) {
      images[i].label = base[i].label;
      before.push_back(base[i].index);
      after.push_back(images[i].index);
      row.mean_change += (after[i] - before[i]) / static_cast<double>(images.size());
    }
    row.auc = area_under_roc(scored(images));
    row.rank_correlation = rank_correlation(before, after);
    rows.push_back(row);
  }
  return rows;
}

std::string stability_table(const std::vector<StabilityRow>& rows) {
  std::string table = "                       AUC    95 % interval   rank correlation   mean change of the index\n";
  for (const StabilityRow& row : rows) {
    std::array<char, 160> line{};
    std::snprintf(line.data(), line.size(), "%-22s %.3f  %.3f to %.3f  %.3f              %+.3f\n",
                  std::string(row.name).c_str(), row.auc.value, row.auc.low, row.auc.high, row.rank_correlation,
                  row.mean_change);
    table += line.data();
  }
  return table;
}

}  // namespace ilp::richness
