// Calibrates a camera from pictures of a board. Needs a build with OpenCV.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/host/raster.hpp"

namespace ilp::lab {

/// A board, by its inner corners: the points where four squares meet.
struct Board {
  int columns = 9, rows = 6;
  double square = 1;  ///< side of a square, in any unit
};

struct BoardCorner {
  double x = 0, y = 0;  ///< px, pixel centres at integers
  int number = 0;       ///< column + row * Board::columns
};
/// The visible corners: all corners of a chessboard, or at least six of a ChArUco board (charuco_board.hpp).
using BoardCorners = std::vector<BoardCorner>;

struct TargetView {
  double rms_px = 0;                   ///< RMS of the residuals' lengths
  double tilt_rad = 0;                 ///< angle between the board's normal and the optical axis
  std::vector<BoardCorner> residuals;  ///< seen minus projected corners, px; numbers are 0
};

struct TargetCamera {
  CameraModel camera;
  double sigma_fx = 0, sigma_fy = 0, sigma_cx = 0, sigma_cy = 0;  ///< px
  double rms_px = 0;                                              ///< of all views
  double normals_spread_rad = 0;  ///< largest angle between the board's normals of two views, camera frame
  std::vector<TargetView> views;
};

/// Finds the corners of a chessboard; empty unless all are visible. Throws std::runtime_error in a build without
/// OpenCV, and says what to install.
[[nodiscard]] std::optional<BoardCorners> find_chessboard(const host::Raster<std::uint8_t>& picture,
                                                          const Board& board);
/// Calibrates a camera with the lens of COLMAP's OPENCV model from one set of corners per picture (Z. Zhang, "A
/// flexible new technique for camera calibration", PAMI 2000). Throws std::runtime_error if the equations have no
/// solution, and in a build without OpenCV.
[[nodiscard]] TargetCamera calibrate_by_boards(const std::vector<BoardCorners>& seen, const Board& board, int width,
                                               int height);

}  // namespace ilp::lab
