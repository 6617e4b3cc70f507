#include "sim/tools/lab/target_calibration.hpp"

#include <stdexcept>

#ifdef ILP_HAVE_OPENCV_CALIB3D

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace ilp::lab {
namespace {

/// Of the corners that are seen, on the board.
std::vector<cv::Point3f> places_of(const BoardCorners& seen, const Board& board) {
  std::vector<cv::Point3f> points;
  for (const BoardCorner& corner : seen) {
    const int column = corner.number % board.columns, row = corner.number / board.columns;
    points.emplace_back(static_cast<float>(column * board.square), static_cast<float>(row * board.square), 0.0F);
  }
  return points;
}

/// Of the board, in the camera's axes.
cv::Vec3d normal_of(const cv::Mat& turn) {
  cv::Matx33d rotation;
  cv::Rodrigues(turn, rotation);
  return {rotation(0, 2), rotation(1, 2), rotation(2, 2)};
}

double angle(const cv::Vec3d& a, const cv::Vec3d& b) {
  return std::acos(std::clamp(std::fabs(a.dot(b)), 0.0, 1.0));
}

TargetView view_of(const std::vector<cv::Point3f>& board, const BoardCorners& seen, const cv::Mat& turn,
                   const cv::Mat& place, const cv::Matx33d& camera, const cv::Mat& lens) {
  std::vector<cv::Point2f> computed;
  cv::projectPoints(board, turn, place, camera, lens, computed);
  TargetView view;
  double squares = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const BoardCorner residual{seen[i].x - computed[i].x, seen[i].y - computed[i].y};
    squares += residual.x * residual.x + residual.y * residual.y;
    view.residuals.push_back(residual);
  }
  view.rms_px = std::sqrt(squares / static_cast<double>(seen.size()));
  view.tilt_rad = angle(normal_of(turn), {0, 0, 1});
  return view;
}

}  // namespace

std::optional<BoardCorners> find_chessboard(const host::Raster<std::uint8_t>& picture, const Board& board) {
  host::Raster<std::uint8_t> copy = picture;
  const cv::Mat grey(picture.height, picture.width, CV_8UC1, copy.samples.data());
  std::vector<cv::Point2f> found;
  // The sector-based detector: A. Duda, U. Frese, "Accurate detection and localization of checkerboard corners",
  // BMVC 2018.
  const int how = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY | cv::CALIB_CB_EXHAUSTIVE;
  if (!cv::findChessboardCornersSB(grey, {board.columns, board.rows}, found, how)) return std::nullopt;
  BoardCorners corners;
  for (const cv::Point2f& point : found) corners.push_back({point.x, point.y, static_cast<int>(corners.size())});
  return corners;
}

TargetCamera calibrate_by_boards(const std::vector<BoardCorners>& seen, const Board& board, int width, int height) {
  std::vector<std::vector<cv::Point3f>> boards;
  std::vector<std::vector<cv::Point2f>> images;
  for (const BoardCorners& corners : seen) {
    boards.push_back(places_of(corners, board));
    std::vector<cv::Point2f>& image = images.emplace_back();
    for (const BoardCorner& corner : corners) {
      image.emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y));
    }
  }
  cv::Mat camera_matrix, lens, sigmas, view_sigmas, view_errors;
  std::vector<cv::Mat> turns, places;
  TargetCamera result;
  try {
    result.rms_px = cv::calibrateCamera(boards, images, {width, height}, camera_matrix, lens, turns, places, sigmas,
                                        view_sigmas, view_errors, cv::CALIB_FIX_K3);
  } catch (const cv::Exception& error) {
    throw std::runtime_error("the camera cannot be computed from these pictures (" + error.err +
                             "): take others from other directions");
  }
  const cv::Matx33d k = camera_matrix;
  result.camera = {.width = width,
                   .height = height,
                   .fx = k(0, 0),
                   .fy = k(1, 1),
                   .cx = k(0, 2),
                   .cy = k(1, 2),
                   .k1 = lens.at<double>(0),
                   .k2 = lens.at<double>(1),
                   .p1 = lens.at<double>(2),
                   .p2 = lens.at<double>(3)};
  result.sigma_fx = sigmas.at<double>(0);
  result.sigma_fy = sigmas.at<double>(1);
  result.sigma_cx = sigmas.at<double>(2);
  result.sigma_cy = sigmas.at<double>(3);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    result.views.push_back(view_of(boards[i], seen[i], turns[i], places[i], k, lens));
    for (std::size_t j = 0; j < i; ++j) {
      result.normals_spread_rad = std::max(result.normals_spread_rad, angle(normal_of(turns[i]), normal_of(turns[j])));
    }
  }
  return result;
}

}  // namespace ilp::lab

#else

namespace ilp::lab {
namespace {

[[noreturn]] void refuse() {
  throw std::runtime_error(
      "this build has no OpenCV: apt-get install libopencv-calib3d-dev, then cmake --preset host and build ilp-lab "
      "again");
}

}  // namespace

std::optional<BoardCorners> find_chessboard(const host::Raster<std::uint8_t>&, const Board&) {
  refuse();
}

TargetCamera calibrate_by_boards(const std::vector<BoardCorners>&, const Board&, int, int) {
  refuse();
}

}  // namespace ilp::lab

#endif
