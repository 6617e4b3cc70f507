// Finds the pose of a keyframe on a map. The keyframe is drawn on the map's grid with its prior pose, each of its
// patches is searched for in a window, and the patches vote for a shift. A missing result is acceptable, a wrong one is
// not.
//
// A sense is a way to compare: with the map's image relit by the present sun (`relit`), with the map's heights shaded
// by that sun (`shape`), or the keyframe's relief with the map's (`relief`), which does not depend on light. Patches
// are compared by the directions of gradients. `shape`, `relief` and small patches use grey or height as well.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/base/result.hpp"
#include "fsw/vision/map/keyframe_sheet.hpp"
#include "fsw/vision/map/map_channels.hpp"
#include "fsw/vision/map/map_light.hpp"
#include "fsw/vision/map/map_plan.hpp"
#include "fsw/vision/map/map_pose.hpp"
#include "fsw/vision/map/map_repeats.hpp"
#include "fsw/vision/map/map_votes.hpp"
#include "fsw/vision/map/map_window.hpp"

namespace ilp {

struct MapRegistrationParams {
  double sun_limit_rad = 1.05;  ///< for `relit`: largest azimuth between both suns; beyond it, other sides are lit
  double ambient = 0.25;        ///< share of the light on level ground that comes from the sky
  double min_evidence = 10;     ///< least vote_evidence() of a fix; wrong ground has reached 6.5
  double patch_sigma_px = 0.1;  ///< least standard deviation of a patch's position, px
  bool use_relit = true, use_shape = true;
};

/// Depths of the keyframe along the optical axis, m; 0: unknown. Sample (i, j) belongs to the pixel (first_px + i
/// step_px, first_px + j step_px).
struct KeyframeDepths {
  ImageView<const float> depth_m;
  double first_px = 0, step_px = 1;
};

/// Input of a registration. The data it points to must not change until the registration is done.
struct MapRegistrationInput {
  MapPlan plan;
  MapWindow window;
  MapPrior prior;
  std::span<const MapKeyframe> keyframes;  ///< at least one; the prior is that of the first
  SunDirection sun;                        ///< when the keyframes were exposed
  const KeyframeDepths* depths = nullptr;  ///< of the first keyframe. Not null: only relief is compared
};

/// One registration, in slices of about 6 million multiplications.
class MapRegistration {
 public:
  /// Returns `invalid_argument` with map_window if the window and the plan are out of range or do not fit, and with
  /// map_keyframe if there is no keyframe or a pose is not finite; the errors of validate(camera); `image_size_changed`
  /// if an image does not have the size of its camera.
  Status begin(const MapRegistrationInput& input, const MapRegistrationParams& params,
               MapRegistrationWorkspace& workspace);
  /// Does one slice. Returns false if the registration is done.
  Result<bool> step();
  [[nodiscard]] bool done() const { return phase_ == Phase::done; }
  [[nodiscard]] const MapFixResult& result() const { return result_; }

 private:
  enum class Phase : std::uint8_t {
    sheet,
    sheet_channels,
    window,
    window_channels,
    patches,
    points,
    conclude,
    repeats,
    done
  };
  /// Result of one sense, and the positions of its patches.
  struct Candidate {
    MapSense sense = MapSense::relit;
    MapVote vote;
    struct Place {
      std::int16_t column, row;  ///< first cell of the patch in the sheet
      float shift_column_px, shift_row_px;
    };
    FixedVector<Place, max_map_patches> places;
  };

  Status check() const;
  void choose_senses();
  Status begin_drawing();
  Status begin_sheet();
  Status draw_sheet();
  void prepare_sheet();
  void fill_window();
  void prepare_window();
  void search_patches();
  void count();
  void place_patches();
  Status search_again();
  void next_sense();
  Status conclude();
  [[nodiscard]] bool fix(const Candidate& candidate);
  [[nodiscard]] double own_height(const Candidate::Place& place) const;
  [[nodiscard]] bool is_sane(std::span<const MapSighting> sightings, const MapPoseParams& params) const;
  void take_points(std::span<const MapSighting> sightings);
  [[nodiscard]] MapSense sense() const { return senses_[sense_]; }
  [[nodiscard]] std::int32_t lags() const { return 2 * input_.plan.search_px + 1; }
  [[nodiscard]] SheetSums sums() const;

  MapRegistrationInput input_;
  MapRegistrationParams params_;
  MapRegistrationWorkspace* workspace_ = nullptr;
  Phase phase_ = Phase::done;
  MapLighting lighting_;
  double level_m_ = 0;  ///< mean known height of the window, or MapWindow::ground_m
  bool has_heights_ = false;
  SheetPainter painter_;
  std::size_t keyframe_ = 0;
  std::int32_t row_ = 0;
  float soft_ = 0;
  ValueScale sheet_scale_;
  std::int32_t patches_ = 0, patch_ = 0;
  std::int32_t textured_ = 0;    ///< patches with texture
  std::int64_t known_lags_ = 0;  ///< sum over the patches that are used
  std::array<MapSense, 2> senses_{};
  std::size_t sense_count_ = 0, sense_ = 0;
  std::array<Candidate, 2> candidates_;
  RepeatSearch repeats_;
  bool again_ = false;         ///< the keyframes are drawn again, with the pose that was found
  RigidTransform by_prior_;    ///< prior's map frame from the map frame; identity before a pose is found
  RigidTransform level_pose_;  ///< the pose found with the attitude of the prior
  MapFixResult result_;
};

}  // namespace ilp
