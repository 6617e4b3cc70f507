// Measures the value of a mission: how much of all visible ground has come down with correct heights and good images
// (docs/products.md).
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"
#include "sim/world/height_grid.hpp"
#include "sim/world/terrain_posts.hpp"

namespace ilp::score {

/// Ground is known if its height error is at most this percentage of the flying height: half a pixel on the ground for
/// a focal length of 550 px.
inline constexpr double known_height_percent = 0.1;
/// The shape (relief) of the ground is its height minus the mean height of a square window. The window extends this
/// share of the flying height to each side. Drift of the poses, which bends the map, is nearly constant within the
/// window.
inline constexpr double relief_window = 0.05;
/// The shape is known if its error is at most this percentage of the flying height.
inline constexpr double known_relief_percent = 0.05;
/// Least PSNR of a feature in the images to be seen, and to be seen well; least share of the feature's disc with images
/// and with heights.
inline constexpr double seen_psnr_db = 30, seen_well_psnr_db = 35, feature_disc_share = 0.8;

struct GroundValue {
  std::size_t cells = 0;         ///< cells with a true height: all ground that any frame of the flight has seen
  std::size_t covered = 0;       ///< cells with a merged height
  std::size_t known = 0;         ///< covered cells with a height error within known_height_percent
  std::size_t known_relief = 0;  ///< covered cells with an error of shape within known_relief_percent
  /// Half of all cells have at most this error, % of the flying height. Cells without a height count as infinite error.
  double half_percent = unknown;
  double relief_median_percent = unknown;  ///< error of the shape, % of the flying height
  double relief_p95_percent = unknown;
  std::size_t features = 0;
  std::size_t seen = 0, seen_well = 0;  ///< features that came down in images and heights
  /// Sum of the features' mean squared grey errors. A point without an image counts as an error of 64 grey levels.
  double feature_squares = 0;

  [[nodiscard]] double coverage() const { return share(covered, cells); }
  [[nodiscard]] double known_share() const { return share(known, cells); }
  [[nodiscard]] double known_relief_share() const { return share(known_relief, cells); }
  [[nodiscard]] double feature_share() const { return share(seen, features); }
  [[nodiscard]] double feature_well_share() const { return share(seen_well, features); }

 private:
  static double share(std::size_t part, std::size_t whole) {
    return whole == 0 ? unknown : static_cast<double>(part) / static_cast<double>(whole);
  }
};

/// One strip's errors on the grid of the true heights (HeightScore::error_map) and its flying height.
struct StripErrors {
  const host::Raster<float>* map = nullptr;
  double flying_height = 0;
};

/// Scores heights and shape. Where strips overlap, the first one counts.
[[nodiscard]] GroundValue score_ground(const world::HeightGrid& truth, const std::vector<StripErrors>& strips);

/// Adds the features of a simulated world to `value`, except single rocks. A feature counts if its entire disc has true
/// heights, i.e. the frames of the flight have seen it. It is seen if images show feature_disc_share of the disc with
/// seen_psnr_db, and feature_disc_share has heights. Each point of the disc is judged in the keyframe image with the
/// least error there. `images` is the folder of the original images; keyframes without an original are left out.
void score_features(const std::vector<world::PlantedFeature>& features, const intake::Flight& flight,
                    const world::HeightGrid& truth, const std::vector<StripErrors>& strips, TrueFrames& frames,
                    const std::filesystem::path& images, GroundValue& value);

/// Features of the world in the rectangle of the true heights. The world is described by scenario.ini in the parent
/// folder of `truth`; no features without this file.
[[nodiscard]] std::vector<world::PlantedFeature> planted_features(const std::filesystem::path& truth,
                                                                  const world::HeightGrid& heights);

/// Numbers for the summary of a score.
[[nodiscard]] std::map<std::string, double> ground_value_summary(const GroundValue& value);

}  // namespace ilp::score
