// Reads and writes public bundle-adjustment problems of any size: "Bundle Adjustment in the Large" (BAL; S. Agarwal, N.
// Snavely, S. Seitz, R. Szeliski, ECCV 2010) and COLMAP's text models. The flight's bundle adjustment can solve a
// window of their cameras.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "sim/tools/lab/colmap_reader.hpp"

namespace ilp::lab {

struct SparseCamera {
  BundleCamera adjusted;                  ///< intrinsics without distortion, pose
  std::array<double, 3> intrinsics = {};  ///< BAL only: focal length in px, k1, k2
  std::string name;                       ///< COLMAP only: image name
};

struct SparseObservation {
  std::uint32_t camera = 0, point = 0;
  /// Measured position in px. BAL: as in the file, from the principal point with y up. COLMAP: converted so that
  /// integers are pixel centres.
  double x = 0, y = 0;
  double ideal_x = 0, ideal_y = 0;  ///< the same without distortion, y down
};

struct SparseProblem {
  std::vector<SparseCamera> cameras;
  std::vector<Vec3> points;
  std::vector<SparseObservation> observations;
  std::optional<CameraModel> colmap;  ///< camera of a COLMAP model; empty for BAL
};

/// Whether the file is a BAL problem: its header is `cameras points observations`, exactly `observations` lines of four
/// numbers follow, and the next line has another length. A window file of `bundle` has the same header and one line of
/// four numbers more.
[[nodiscard]] bool is_bal(const std::filesystem::path& file);

/// Throws std::runtime_error that names the file and, for a malformed line, its number; also if the lens model cannot
/// be inverted at an observation.
[[nodiscard]] SparseProblem read_bal(const std::filesystem::path& file);
/// Cameras are in the order of their image names. Throws std::runtime_error that names the file, as above; also for an
/// observation of a point that points3D.txt lacks.
[[nodiscard]] SparseProblem read_colmap_problem(const std::filesystem::path& folder);

/// `count` cameras from index `first` on. A count of 0 means all cameras of the problem, whatever `first` is.
struct CameraRange {
  std::uint32_t first = 0, count = 0;
};

/// A part of a problem that fits the capacities of the flight's bundle adjustment. Cameras and points are numbered from
/// 0.
struct SparseWindow {
  SparseProblem problem;
  std::size_t left_out = 0;  ///< points seen by two cameras or more that a capacity excludes
};
/// Chooses the cameras of the range and the points that at least two of them see. Where a capacity is too small, points
/// with most observations are kept. Throws std::runtime_error if the range is outside the problem or longer than
/// limits::max_bundle_cameras, or if no point is seen twice.
[[nodiscard]] SparseWindow choose_window(const SparseProblem& problem, const CameraRange& cameras);

/// Makes the problem for the flight's bundle adjustment. The first camera is fixed. The distance from it to the first
/// camera at another position is held, which fixes the scale.
void make_bundle(const SparseProblem& window, BundleProblem& bundle);
/// Copies the adjusted poses and points from `bundle` to `window`.
void take_bundle(const BundleProblem& bundle, SparseProblem& window);

/// Writes the format that was read: the BAL file `place`, or a COLMAP text model in the folder `place`.
void write_problem(const SparseProblem& problem, const std::filesystem::path& place);

}  // namespace ilp::lab
