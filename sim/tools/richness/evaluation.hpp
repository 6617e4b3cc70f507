// The Image Richness Index on planted worlds: how often an image with a feature outranks one without.
#pragma once

#include <functional>
#include <string>
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

}  // namespace ilp::richness
