#include "sim/tools/richness/evaluation.hpp"

#include <cmath>
#include <cstdio>

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

}  // namespace ilp::richness
