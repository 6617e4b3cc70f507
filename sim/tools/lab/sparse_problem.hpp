// Bundle adjustment problems of others, of any size: "Bundle Adjustment in the Large" (S. Agarwal, N. Snavely, S.
// Seitz, R. Szeliski, ECCV 2010) and COLMAP's text model. A window of their cameras fits the flight's adjustment.
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
  std::array<double, 3> intrinsics = {};  ///< of BAL: f, k1, k2
  std::string name;                       ///< of COLMAP's image
};

struct SparseObservation {
  std::uint32_t camera = 0, point = 0;
  double x = 0, y = 0;              ///< as the file has it; of COLMAP px with centres at integers
  double ideal_x = 0, ideal_y = 0;  ///< without distortion
};

struct SparseProblem {
  std::vector<SparseCamera> cameras;
  std::vector<Vec3> points;
  std::vector<SparseObservation> observations;
  std::optional<CameraModel> colmap;  ///< the camera of a COLMAP model; none: BAL
};

/// Whether the file is a BAL problem: after `cameras points observations` and so many lines of four numbers, it has
/// other lines. The window file of `bundle` has one more line of four.
[[nodiscard]] bool is_bal(const std::filesystem::path& file);

/// std::runtime_error names file and line; refused is an observation that no ray of its lens makes.
[[nodiscard]] SparseProblem read_bal(const std::filesystem::path& file);
/// The images in the order of their names.
[[nodiscard]] SparseProblem read_colmap_problem(const std::filesystem::path& folder);

/// `count` cameras from `first` on; all for a count of 0.
struct CameraRange {
  std::uint32_t first = 0, count = 0;
};

/// Cameras and points of the problem that take part, as a problem of its own.
struct SparseWindow {
  SparseProblem problem;
  std::size_t left_out = 0;  ///< points that two of the cameras see, for which the adjustment has no room
};
/// The points that two or more of the cameras see; those of most observations first where there is no room for all.
/// std::runtime_error names the limit for too many cameras, and says what to do.
[[nodiscard]] SparseWindow choose_window(const SparseProblem& problem, const CameraRange& cameras);

/// The first camera is fixed, and its distance from another one holds the scale.
void make_bundle(const SparseProblem& window, BundleProblem& bundle);
/// The adjusted poses and points.
void take_bundle(const BundleProblem& bundle, SparseProblem& window);

/// In the form that it came in: a BAL file, or a folder for a COLMAP text model.
void write_problem(const SparseProblem& problem, const std::filesystem::path& place);

}  // namespace ilp::lab
