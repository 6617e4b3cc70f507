// A camera from pictures of a board, by OpenCV where this build has it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/host/raster.hpp"

namespace ilp::lab {

/// Inner corners: places where four squares meet.
struct Board {
  int columns = 9, rows = 6;
  double square = 1;  ///< side of a square, in any unit
};

struct BoardCorner {
  double x = 0, y = 0;  ///< px, pixel centres at integers
  int number = 0;       ///< column + row x columns of the board
};
/// Those that are seen: of a chessboard all, of a ChArUco board (charuco_board.hpp) at least six.
using BoardCorners = std::vector<BoardCorner>;

struct TargetView {
  double rms_px = 0;                   ///< root mean square distance of the corners from where the camera puts them
  double tilt_rad = 0;                 ///< between the board's normal and the camera's axis
  std::vector<BoardCorner> residuals;  ///< seen minus computed
};

struct TargetCamera {
  CameraModel camera;
  double sigma_fx = 0, sigma_fy = 0, sigma_cx = 0, sigma_cy = 0;
  double rms_px = 0;
  double normals_spread_rad = 0;  ///< largest angle between the normals of two boards, as the camera sees them
  std::vector<TargetView> views;
};

/// Throws std::runtime_error that says what to install, in a build without OpenCV.
[[nodiscard]] std::optional<BoardCorners> find_chessboard(const host::Raster<std::uint8_t>& picture,
                                                          const Board& board);
/// Z. Zhang, "A flexible new technique for camera calibration", PAMI 2000, with the lens of COLMAP's OPENCV model.
/// Throws std::runtime_error when the equations have no solution.
[[nodiscard]] TargetCamera calibrate_by_boards(const std::vector<BoardCorners>& seen, const Board& board, int width,
                                               int height);

}  // namespace ilp::lab
