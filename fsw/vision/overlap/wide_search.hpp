// Exhaustive search for the similarity between two images of up to 160 px by sums of absolute differences: any
// rotation, any scale, any shift (paper 3.1). It is divided into jobs that a compute device can do (docs/compute.md).
//
// Both images are normalised to the same local mean and contrast, so that sums of differences are comparable. Image a
// is rotated and scaled, and sampled at every fourth pixel along x and y. The samples are compared with b at every
// second pixel of shift. A job computes in integers only, so every machine gives the same bytes.
#pragma once

#include <array>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/overlap/coarse_search.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp {

inline constexpr std::int32_t wide_max_side = 160;     ///< px, of both images
inline constexpr std::int32_t wide_sample_px = 4;      ///< distance of two samples of a
inline constexpr std::int32_t wide_plane_rows = 40;    ///< rows of a plane of b, which has one pixel of each 4 x 4
inline constexpr std::int32_t wide_plane_stride = 64;  ///< length of such a row, with padding for the last vector
inline constexpr std::int32_t wide_canvas_side = 85;   ///< samples: 160 px turned by 45 degrees, enlarged by 1.5
inline constexpr std::int32_t wide_canvas_stride = 112;
inline constexpr std::int32_t wide_shift_px = 2;      ///< distance of two shifts
inline constexpr std::int32_t wide_max_shifts = 192;  ///< along each axis
inline constexpr std::size_t wide_job_poses = 32;
/// Mean absolute difference of unrelated images after normalisation.
inline constexpr std::int32_t wide_unrelated = 36;

/// One rotation and scale: how image a is drawn on a canvas, and the shifts of the canvas over b.
struct WidePose {
  std::int32_t start_x, start_y;  ///< position of the canvas's first sample in a, px with 16 fractional bits
  std::int32_t step_x, step_y;    ///< step in a from a sample to the next in its row; (-step_y, step_x) to the next row
  std::int32_t columns, rows;     ///< size of the canvas, samples
  std::int32_t left, top;         ///< px of b at the canvas's first sample, at the first shift
  std::int32_t shifts_x, shifts_y;  ///< number of shifts, wide_shift_px apart
  std::int32_t min_count;           ///< a shift needs at least this many samples that count
  std::int32_t reserved;
};

/// Input of a job. Normalised grey values have mean 128 and standard deviation 32; 0: the pixel does not count.
struct WideInput {
  std::int32_t width, height;  ///< of both images
  std::int32_t pose_count;
  std::int32_t reserved;
  std::array<std::uint8_t, std::size_t{wide_max_side} * wide_max_side> a;  ///< rows of `width` pixels, rounded up to 4
  /// b as 16 planes, with pixel (4 i + x, 4 j + y) at row j, column i of plane 4 y + x; 0 elsewhere.
  std::array<std::uint8_t, std::size_t{16} * wide_plane_rows * wide_plane_stride> b;
  std::array<WidePose, wide_job_poses> poses;
};

/// Output of a job, one word for every pose and shift along y. The lower `wide_shift_bits` have the best shift along x.
/// The upper bits have its score (36 n - d)^2 / n, where d is the sum of absolute differences over n samples. 0: no
/// shift is better than unrelated images.
struct WideOutput {
  std::array<std::array<std::uint32_t, wide_max_shifts>, wide_job_poses> best;
};
inline constexpr int wide_shift_bits = 8;

/// Plan of a search: its rotations and scales, and its jobs.
struct WidePlan {
  std::int32_t width = 0, height = 0;
  double min_overlap = 0.5;
  std::int32_t rotations = 0, scales = 0;

  [[nodiscard]] std::int32_t poses() const { return rotations * scales; }
  [[nodiscard]] std::int32_t jobs() const {
    return (poses() + static_cast<std::int32_t>(wide_job_poses) - 1) / static_cast<std::int32_t>(wide_job_poses);
  }
};

/// Normalises both images and plans the search. Writes everything in `input` except the poses. Returns
/// `invalid_argument` if a side is below limits::min_image_side / 2 or above wide_max_side, `image_size_changed` if the
/// sizes differ.
Status prepare_wide_search(GrayView a, GrayView b, double min_overlap, WideInput& input, WidePlan& plan);
/// The plan alone, for images of this size.
[[nodiscard]] WidePlan plan_wide_search(std::int32_t width, std::int32_t height, double min_overlap);
/// Makes example job `number` from synthetic ground, to compare a device with the processor.
void make_wide_example(std::uint32_t number, WideInput& input);
/// Writes the poses of job `job` of the plan.
void fill_wide_job(const WidePlan& plan, std::int32_t job, WideInput& input);

struct WideWorkspace {
  // Masks: 255 where the pixel counts.
  std::array<std::uint8_t, std::size_t{wide_canvas_side} * wide_canvas_stride> canvas, canvas_mask;
  std::array<std::uint8_t, std::size_t{16} * wide_plane_rows * wide_plane_stride> b_mask;
};
/// Searches one pose of a job. This is the reference: a device gives the same bytes.
void search_wide_pose(const WideInput& input, std::size_t pose, WideWorkspace& workspace,
                      std::array<std::uint32_t, wide_max_shifts>& best);

/// Inserts the peaks of job `job` into `candidates`, best first. Any content of `output` is accepted.
void collect_wide_peaks(const WidePlan& plan, std::int32_t job, const WideInput& input, const WideOutput& output,
                        CoarseCandidates& candidates);

}  // namespace ilp
