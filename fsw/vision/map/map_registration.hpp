// Finds where a keyframe stands on a map: the keyframe is drawn on the map's grid by its prior pose, pieces of it are
// each sought in a window, and they vote. A wrong answer must not happen; no answer may.
//
// Senses: the map's image under the sun of the moment (`relit`), the map's heights under that sun (`shape`), and the
// keyframe's own relief against the map's (`relief`), which has no light in it. Channels are the directions of
// gradients, and grey or height as well for shape and relief, and for small patches.
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
  double sun_limit_rad = 1.05;  ///< beyond it the bright side of what stands out is its other side
  double ambient = 0.25;        ///< share of the light on level ground that comes from the whole sky
  double min_evidence = 10;     ///< ground that is not there has had up to 6.5
  double patch_sigma_px = 0.1;  ///< of a patch's place, at least
  bool use_relit = true, use_shape = true;
};

/// Depths of the keyframe along the optical axis, m; 0: none. Sample (i, j) is that of the pixel
/// (first_px + i step_px, first_px + j step_px).
struct KeyframeDepths {
  ImageView<const float> depth_m;
  double first_px = 0, step_px = 1;
};

/// What a registration is begun with. What it points to stays as it is until the registration is done.
struct MapRegistrationInput {
  MapPlan plan;
  MapWindow window;
  MapPrior prior;
  std::span<const MapKeyframe> keyframes;  ///< one or more, in any order; the first is that of the prior
  SunDirection sun;                        ///< over the keyframes
  const KeyframeDepths* depths = nullptr;  ///< of the first keyframe: then relief is compared, and no light
};

/// One registration in slices of at most some 6 million multiplications.
class MapRegistration {
 public:
  /// `invalid_argument`: map_window (size, pixel or plan of the window), map_keyframe (none), and what validate() finds
  /// in a camera; `image_size_changed`.
  Status begin(const MapRegistrationInput& input, const MapRegistrationParams& params,
               MapRegistrationWorkspace& workspace);
  /// One slice. False when the result is there.
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
  /// What one sense says, and the places of its patches.
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
  double level_m_ = 0;  ///< mean height of the window, or what it states where none is known
  bool has_heights_ = false;
  SheetPainter painter_;
  std::size_t keyframe_ = 0;
  std::int32_t row_ = 0;
  float soft_ = 0;
  ValueScale sheet_scale_;
  std::int32_t patches_ = 0, patch_ = 0;
  std::int32_t textured_ = 0;    ///< patches that the window may know
  std::int64_t known_lags_ = 0;  ///< of all patches that are used
  std::array<MapSense, 2> senses_{};
  std::size_t sense_count_ = 0, sense_ = 0;
  std::array<Candidate, 2> candidates_;
  RepeatSearch repeats_;
  bool again_ = false;         ///< the keyframes are drawn by the pose that was found
  RigidTransform by_prior_;    ///< the map as the prior has it, from the map: identity until then
  RigidTransform level_pose_;  ///< that was found with the attitude of the prior
  MapFixResult result_;
};

}  // namespace ilp
