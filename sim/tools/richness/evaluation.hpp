// Evaluates the Image Richness Index on planted worlds: how often an image with a feature outranks an image without
// one.
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
  std::size_t world = 0;  ///< index of the world in its WorldRange
  int keyframe = 0;
  Label label = Label::neither;
  double feature_share = 0;  ///< as of PlantedKeyframe
  RichnessCues cues;
  double index = 0;
};

struct WorldRange {
  WorldSet set = WorldSet::tuning;
  std::uint64_t first_seed = 1;
  std::uint64_t seeds = 1;  ///< number of seeds; each gives 25 worlds, one for every ground and feature

  [[nodiscard]] std::size_t worlds() const;
  [[nodiscard]] PlantedWorld world(std::size_t number) const;
};

/// Computes the index of all keyframes, in the order of worlds and keyframes. Each world is a separate flight with its
/// own history. The result does not depend on the number of threads (0: one per core). Without `with_depth` the index
/// gets no depths.
[[nodiscard]] std::vector<EvaluatedImage> evaluate(const WorldRange& range, const Viewing& viewing,
                                                   const RichnessParams& params, std::size_t threads,
                                                   bool with_depth = true);

/// Computes index and novelty again from the cues, with other parameters.
void score_again(const RichnessParams& params, std::vector<EvaluatedImage>& images);

/// Scores for a ROC curve: the images with the label `interesting` that `interesting` selects, and the images with the
/// label `plain` that `plain` selects.
using Choice = std::function<bool(const EvaluatedImage&)>;
[[nodiscard]] std::vector<ScoredImage> scored(const std::vector<EvaluatedImage>& images, const Choice& interesting,
                                              const Choice& plain);
/// All interesting and all plain images.
[[nodiscard]] std::vector<ScoredImage> scored(const std::vector<EvaluatedImage>& images);

/// AUC of the index as text: a line per ground, a line per feature, and a line for all images.
[[nodiscard]] std::string auc_table(const std::vector<EvaluatedImage>& images);
/// AUC of every single cue as text.
[[nodiscard]] std::string cue_table(const std::vector<EvaluatedImage>& images);
/// A line per image with the raw cues.
[[nodiscard]] std::string csv(const std::vector<EvaluatedImage>& images);

struct NamedCue {
  const char* name;
  double RichnessCues::*cue;
  CueScale RichnessParams::*scale;
};
[[nodiscard]] std::span<const NamedCue> named_cues();

// Fits default parameters of the index to images with known truth.

/// Fits `half` and weight of every cue x, which counts as x / (x + half).
/// Half: the geometric mean of the cue's medians over plain and over interesting images, so that the squashed cue
/// changes most between them. Weights: logistic regression of the label on the squashed cues, with non-negative weights
/// (projected gradient descent, slight weight decay). Plain and interesting images have the same total weight, which
/// the kinds of features share equally. The weights are scaled to a sum of 10 and raised to `least_weight`, because
/// other worlds may need a cue that these do not. All values are rounded to two digits. Images without terrain are left
/// out.
[[nodiscard]] RichnessParams fit_richness(std::vector<EvaluatedImage> images, double least_weight = 0.3);

// Tests whether the index ranks the same ground equally under other viewing conditions.

struct ViewingChange {
  std::string_view name;
  Viewing viewing;
  bool with_depth = true;
};

/// The base first, then gains of 0.5 and 2, offsets of +20 and -20 grey levels, height factors of 0.7 and 1.5, more
/// noise, more haze, exact depth and no depth. All see the same patches of ground.
[[nodiscard]] std::vector<ViewingChange> viewing_changes();

struct StabilityRow {
  std::string_view name;
  Auc auc;                      ///< with the labels of the base
  double rank_correlation = 1;  ///< with the index of the base, over all images
  double mean_change = 0;       ///< mean change of the index from the base
};

/// Compares every viewing change with the first one.
[[nodiscard]] std::vector<StabilityRow> stability(const WorldRange& range, const std::vector<ViewingChange>& changes,
                                                  const RichnessParams& params, std::size_t threads);

[[nodiscard]] std::string stability_table(const std::vector<StabilityRow>& rows);

}  // namespace ilp::richness
