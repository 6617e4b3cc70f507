// The mission's value: how much of all visible ground the ground segment holds after a flight (docs/products.md).
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/tools/score/true_frames.hpp"
#include "sim/world/height_grid.hpp"
#include "sim/world/terrain_posts.hpp"

namespace ilp::score {

/// Errors below this share of the flying height count as known ground: half a pixel on the ground at 550 px of focal
/// length.
inline constexpr double known_height_percent = 0.1;
/// The shape of the ground: heights against the mean around them, in a square of this share of the flying height each
/// way. The drift of the poses, which bends the whole map, is nearly the same everywhere in it.
inline constexpr double relief_window = 0.05;
/// Deviations below this share of the flying height count as a known shape.
inline constexpr double known_relief_percent = 0.05;
/// PSNR of a feature in the images for it to be seen, and to be seen well; the share of its disc that images and
/// heights must show.
inline constexpr double seen_psnr_db = 30, seen_well_psnr_db = 35, feature_disc_share = 0.8;

struct GroundValue {
  std::size_t cells = 0;          ///< of the true heights: all ground that any frame of the flight has seen
  std::size_t covered = 0;        ///< with a merged height
  std::size_t known = 0;          ///< of `covered`: right within known_height_percent
  std::size_t known_relief = 0;   ///< of `covered`: their shape is right within known_relief_percent
  double half_percent = unknown;  ///< half of all cells are right within it; ground without height is never right
  double relief_median_percent = unknown;  ///< error of the ground's shape, of the flying height
  double relief_p95_percent = unknown;
  std::size_t features = 0;
  std::size_t seen = 0, seen_well = 0;  ///< features that came down in images and heights
  double feature_squares = 0;  ///< sum over the features of their mean squared grey error; unseen: a grey image's

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

/// Where strips overlap, the first one counts.
[[nodiscard]] GroundValue score_ground(const world::HeightGrid& truth, const std::vector<StripErrors>& strips);

/// Craters, boulder fields, channels and scarps of a simulated world. A feature counts when some frame has seen its
/// whole disc; it has come down when images show 80 % of the disc with a PSNR of 30 dB or more, and heights lie on 80
/// %. Every point of the disc is judged in the image that shows it best, whichever keyframe's that is. `images` are the
/// originals by name; keyframes without one are left out.
void score_features(const std::vector<world::PlantedFeature>& features, const intake::Flight& flight,
                    const world::HeightGrid& truth, const std::vector<StripErrors>& strips, TrueFrames& frames,
                    const std::filesystem::path& images, GroundValue& value);

/// The features of the world that scenario.ini beside the truth describes, where the heights are known; none without
/// that file.
[[nodiscard]] std::vector<world::PlantedFeature> planted_features(const std::filesystem::path& truth,
                                                                  const world::HeightGrid& heights);

[[nodiscard]] std::map<std::string, double> ground_value_summary(const GroundValue& value);

}  // namespace ilp::score
