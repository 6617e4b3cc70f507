// Scores depths, heights, masks, overlaps, links and images of a flight against the truth.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/tools/score/depth_score.hpp"
#include "sim/tools/score/ground_value.hpp"
#include "sim/tools/score/height_score.hpp"
#include "sim/tools/score/link_score.hpp"
#include "sim/tools/score/mask_score.hpp"
#include "sim/tools/score/overlap_score.hpp"
#include "sim/tools/score/quality_score.hpp"
#include "sim/tools/score/track_score.hpp"

namespace ilp::score {

struct DenseOptions {
  /// Folder with height.pfm, height.pgw and colmap/cameras.txt (sim/world/truth.hpp); may be empty.
  std::filesystem::path truth;
  std::filesystem::path images;  ///< the original images; may be empty
  /// The camera that took the images. If empty, the camera of the truth's COLMAP model, or else the flight's camera.
  std::optional<CameraModel> camera;
  double target_overlap = 0;  ///< 0: unknown
};

struct KeyframeDense {
  std::int64_t strip_id = 0;
  std::optional<DepthScore> depth;
  std::optional<MaskScore> mask;
  std::optional<QualityScore> quality;
};

struct StripDense {
  AlignedStrip aligned;
  double flying_height = 0;           ///< median true depth of the keyframes, truth's unit
  std::optional<HeightScore> height;  ///< empty without true heights or a merged map
};

struct DenseScore {
  std::map<std::int64_t, KeyframeDense> keyframes;
  std::map<std::int64_t, StripDense> strips;  ///< strips that could be aligned to the truth
  // Over all pixels, cells and products of the flight:
  DepthScore depth;
  ErrorPercent height;
  std::optional<ErrorPercent> metric_height;
  MaskScore mask;
  QualityScore quality;
  OverlapScore overlap;
  LinkScore links;
  TrackScore track;
  std::optional<GroundValue> value;  ///< empty without true heights
  std::vector<std::string> remarks;  ///< what could not be measured, and why
};

/// Scores a flight against the poses and depths of `reference`. Parts without truth (depth maps, height grid, original
/// images) stay empty. Throws nothing but std::bad_alloc.
[[nodiscard]] DenseScore score_dense(const intake::Flight& flight, const report::Reference& reference,
                                     const DenseOptions& options);

}  // namespace ilp::score
