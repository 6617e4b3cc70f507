// The Image Richness Index on planted worlds: how often an image with a feature outranks one without.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "fsw/vision/terrain/richness.hpp"
#include "sim/tools/richness/planted_keyframes.hpp"
#include "sim/tools/richness/roc.hpp"

namespace ilp::richness {

struct EvaluatedImage {
  WorldSet set = WorldSet::tuning;
  GroundKind ground = GroundKind::plains;
  world::FeatureKind feature = world::FeatureKind::crater;
  std::uint64_t seed = 0;
  std::size_t world = 0;  ///< running number
  int keyframe = 0;
  Label label = Label::neither;
  double feature_share = 0;
  RichnessCues cues;
  double index = 0;
};

struct WorldRange {
  WorldSet set = WorldSet::tuning;
  std::uint64_t first_seed = 1;
  std::uint64_t seeds = 1;  ///< each with every ground and every feature: 25 worlds

  [[nodiscard]] std::size_t worlds() const;
  [[nodiscard]] PlantedWorld world(std::size_t number) const;
};

/// Every world is a flight of its own, with a history of its own. World by world, keyframe by keyframe; the same for
/// any number of threads (0: one per core). `with_depth` false hides the depth from the index.
[[nodiscard]] std::vector<EvaluatedImage> evaluate(const WorldRange& range, const Viewing& viewing,
                                                   const RichnessParams& params, std::size_t threads,
                                                   bool with_depth = true);

/// Index and novelty computed again from the cues, with other parameters.
void score_again(const RichnessParams& params, std::vector<EvaluatedImage>& images);

/// Images with features (of some kind, where `chosen` says so) against all plain images that `plain` chooses.
using Choice = std::function<bool(const EvaluatedImage&)>;
[[nodiscard]] std::vector<ScoredImage> scored(const std::vector<EvaluatedImage>& images, const Choice& interesting,
                                              const Choice& plain);
[[nodiscard]] std::vector<ScoredImage> scored(const std::vector<EvaluatedImage>& images);

/// One line per ground, per feature and for all.
[[nodiscard]] std::string auc_table(const std::vector<EvaluatedImage>& images);
/// AUC of every cue on its own.
[[nodiscard]] std::string cue_table(const std::vector<EvaluatedImage>& images);
/// One line per image, with the raw cues.
[[nodiscard]] std::string csv(const std::vector<EvaluatedImage>& images);

struct NamedCue {
  const char* name;
  double RichnessCues::*cue;
  CueScale RichnessParams::*scale;
};
[[nodiscard]] std::span<const NamedCue> named_cues();

// Defaults for what makes an image rich, from images with known truth.

/// Halves: for every cue the geometric mean of its medians over the plain and over the interesting images, so that the
/// squashed cue changes most between the two. Weights: logistic regression of the label on the squashed cues, the
/// weights not negative (projected gradient descent, a little weight decay), every kind of feature and the plain images
/// counting alike; then scaled to a sum of 10 and not below `least_weight`, so that no cue is silent: worlds that
/// nobody thought of may need it. All rounded to two digits. Images without terrain are left out.
[[nodiscard]] RichnessParams fit_richness(std::vector<EvaluatedImage> images, double least_weight = 0.3);

// Whether the index ranks the same ground equally when it is seen in other ways.

struct ViewingChange {
  std::string_view name;
  Viewing viewing;
  bool with_depth = true;
};

/// The base, then gains of 0.5 and 2, offsets of 20 grey levels up and down, heights of 0.7 and 1.5, more noise, more
/// haze, exact depth and no depth; the same patches of ground in all.
[[nodiscard]] std::vector<ViewingChange> viewing_changes();

struct StabilityRow {
  std::string_view name;
  Auc auc;                      ///< by the labels of the base
  double rank_correlation = 1;  ///< with the index of the base, over all images
  double mean_change = 0;       ///< of the index
};

/// Every change against the first.
[[nodiscard]] std::vector<StabilityRow> stability(const WorldRange& range, const std::vector<ViewingChange>& changes,
                                                  const RichnessParams& params, std::size_t threads);

[[nodiscard]] std::string stability_table(const std::vector<StabilityRow>& rows);

}  // namespace ilp::richness
