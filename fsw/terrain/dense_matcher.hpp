// Reconstructs the terrain by dense stereo: two final poses -> Depth and Mask of the first keyframe (paper 3.3, 4.2;
// decisions.md, 4, 8, 9).
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/patience.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/terrain/partner_choice.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/depth/pose_error.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/rectification_residual.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "fsw/vision/terrain/cell_depths.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"
#include "fsw/vision/terrain/mask.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// Processes one keyframe after the other, in bands of scanlines. A keyframe is matched with one of the next keyframes
/// of its strip with final poses (choose_partner), panel by panel of the rectification plan. If a farther one gives no
/// depth, it is matched with the next one. Depth with a larger sigma than largest_depth_sigma is dropped.
///
/// A keyframe gets a verdict, and a mask of the ground that no pair has reconstructed, so that its image is not lost,
/// if it has no partner (end of a strip, failed pose), if it has no common ground with the partner, or if matches are
/// not on the same rows of the rectified images. Coverage is carried across such a keyframe by the homographies of the
/// overlap check. A pair that cannot be read gets the verdict too_few_valid. If the checkpoint is older than the
/// records, coverage starts again.
class DenseMatcher final : public StageComponent<ComponentId::dense_matcher> {
 public:
  static const CheckpointForm checkpoint;

  enum class Phase : std::uint8_t {
    idle,
    begin,
    resample,
    match,
    residuals,
    depth,
    errors,
    quality,
    mask,
    coding,
    codes,
    mask_code,
    passed,
    coverage,
    cells,
    record
  };

  struct State {
    std::int64_t coverage_keyframe_id = 0;  ///< the keyframe to which `coverage` belongs; other keyframes have none
    Coverage coverage;
    std::int64_t passed_keyframe_id = 0;  ///< a keyframe without pose between those of a pair; 0: none
    Coverage passed;                      ///< its coverage: the ground of that pair, or of the pair's second image
  };
  template <typename T>
  using RectifiedBuffer = FixedImage<T, limits::max_rectified_pixels>;
  template <typename T>
  using ImageBuffer = FixedImage<T, limits::max_image_pixels>;

  /// Memory in which a record is made after its pair is matched.
  struct RecordWorkspace {
    ImageBuffer<std::uint8_t> mask, sigma_code;
    ImageBuffer<std::uint16_t> codes;
    std::array<std::uint8_t, max_mask_bytes(limits::max_image_pixels)> mask_bytes;
    CoverageWorkspace coverage;
    PoseErrorScratch pose_errors;
  };
  /// Memory for one of the two uses at a time. Each use writes all that it reads.
  union Shared {
    Shared() : stereo() {}
    StereoWorkspace stereo;
    RecordWorkspace record;
  };

  /// The maps of a keyframe's depth.
  struct DepthMaps {
    ImageBuffer<float> inverse, sigma;
    FixedImage<std::uint64_t, static_cast<std::size_t>(supported_words(limits::max_image_width)) *
                                  static_cast<std::size_t>(limits::max_image_height)>
        supported;

    DepthView view() { return {inverse.view(), sigma.view(), supported.view()}; }
  };
  struct Work {
    CameraModel camera;
    // The pair that is processed; a restart drops it.
    Phase phase = Phase::idle;
    Patience patience;
    PoseRecord pose;
    PoseRecord next;  ///< pose of the next keyframe with a pose, to which coverage is carried
    Partner partner;
    RectificationPlan plan;
    std::size_t panel = 0;
    VerticalResidual residual;
    DepthRecord record;  ///< the records of the pair, as far as they are known
    MaskRecord mask;
    std::int32_t row = 0;
    Status event;  ///< the event that the step returns

    [[nodiscard]] const RectifiedPanel& at_panel() const { return plan.panels[panel]; }
  };
  struct Workspace {
    StereoMatcher matcher;
    FrameImage left, right;
    RectifiedBuffer<std::uint8_t> rectified_left, rectified_right, valid_left, valid_right;
    RectifiedBuffer<float> disparity, disparity_sigma;
    DepthMaps maps;
    CellDepths cell_depths{};
    SeenCells now;  ///< how well the pair shows the ground
    Shared shared;
    State after;  ///< the state after the present record
    Coverage before;

    [[nodiscard]] PairGround ground() const {
      return {maps.inverse.view(), maps.sigma.view(), shared.record.mask.view(), now};
    }
  };

  DenseMatcher(Tables store, const MissionParameters& mission);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  }

 private:
  struct Wiring {
    Tables store;
    const MissionParameters& mission;
  };

  Result<bool> pick();
  /// Chooses the partner of the present keyframe.
  Result<Successor> find_partner();
  Result<DepthVerdict> begin_pair();
  Status begin_panel();
  Status resample_band();
  Status match_band();
  Status check_rows();
  Status depth_band();
  Status state_errors();
  Status state_quality();
  Status claim_ground();
  Status choose_coding();
  Status code_depth();
  Status begin_carry();
  Status carry_ground();
  Status advance();
  Status abandon_partner(DepthVerdict verdict, Status reported);
  Status record_without_depth(const PoseRecord& pose, DepthVerdict verdict);
  Status record_abandoned();
  Status write(DepthRecord& record, MaskRecord& mask, std::int64_t next_coverage_id);

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
