#include "sim/tools/lab/charuco_board.hpp"

#include <stdexcept>

#ifdef ILP_HAVE_OPENCV_ARUCO

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <set>
#include <utility>

namespace ilp::lab {
namespace {

namespace aruco = cv::aruco;

// With OpenCV 4.7 dictionaries and boards became values, and the pattern of boards with an even number of rows another
// one: the older one is meant.
#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 407
using DictionaryNumber = aruco::PredefinedDictionaryType;

cv::Ptr<aruco::Dictionary> predefined(DictionaryNumber number) {
  return cv::makePtr<aruco::Dictionary>(aruco::getPredefinedDictionary(number));
}

cv::Ptr<aruco::CharucoBoard> board_of_squares(int columns, int rows, float marker_share,
                                              const cv::Ptr<aruco::Dictionary>& markers) {
  auto board = cv::makePtr<aruco::CharucoBoard>(cv::Size(columns, rows), 1.0F, marker_share, *markers);
  board->setLegacyPattern(true);
  return board;
}

const std::vector<std::vector<cv::Point3f>>& marker_corners(const aruco::CharucoBoard& board) {
  return board.getObjPoints();
}
#else
using DictionaryNumber = aruco::PREDEFINED_DICTIONARY_NAME;

cv::Ptr<aruco::Dictionary> predefined(DictionaryNumber number) {
  return aruco::getPredefinedDictionary(number);
}

cv::Ptr<aruco::CharucoBoard> board_of_squares(int columns, int rows, float marker_share,
                                              const cv::Ptr<aruco::Dictionary>& markers) {
  return aruco::CharucoBoard::create(columns, rows, 1.0F, marker_share, markers);
}

const std::vector<std::vector<cv::Point3f>>& marker_corners(const aruco::CharucoBoard& board) {
  return board.objPoints;
}
#endif

struct NamedDictionary {
  const char* name;
  DictionaryNumber number;
};
/// Of dictionaries with the same first markers, the smallest stands first.
constexpr std::array<NamedDictionary, 21> dictionaries = {{{"4X4_50", aruco::DICT_4X4_50},
                                                           {"4X4_100", aruco::DICT_4X4_100},
                                                           {"4X4_250", aruco::DICT_4X4_250},
                                                           {"4X4_1000", aruco::DICT_4X4_1000},
                                                           {"5X5_50", aruco::DICT_5X5_50},
                                                           {"5X5_100", aruco::DICT_5X5_100},
                                                           {"5X5_250", aruco::DICT_5X5_250},
                                                           {"5X5_1000", aruco::DICT_5X5_1000},
                                                           {"6X6_50", aruco::DICT_6X6_50},
                                                           {"6X6_100", aruco::DICT_6X6_100},
                                                           {"6X6_250", aruco::DICT_6X6_250},
                                                           {"6X6_1000", aruco::DICT_6X6_1000},
                                                           {"7X7_50", aruco::DICT_7X7_50},
                                                           {"7X7_100", aruco::DICT_7X7_100},
                                                           {"7X7_250", aruco::DICT_7X7_250},
                                                           {"7X7_1000", aruco::DICT_7X7_1000},
                                                           {"ARUCO_ORIGINAL", aruco::DICT_ARUCO_ORIGINAL},
                                                           {"APRILTAG_16h5", aruco::DICT_APRILTAG_16h5},
                                                           {"APRILTAG_25h9", aruco::DICT_APRILTAG_25h9},
                                                           {"APRILTAG_36h10", aruco::DICT_APRILTAG_36h10},
                                                           {"APRILTAG_36h11", aruco::DICT_APRILTAG_36h11}}};

using Corners = std::vector<std::vector<cv::Point2f>>;

cv::Ptr<aruco::Dictionary> dictionary_of(const std::string& name) {
  for (const NamedDictionary& known : dictionaries) {
    if (known.name == name) return predefined(known.number);
  }
  throw std::runtime_error("there is no dictionary " + name);
}

std::pair<Corners, std::vector<int>> markers_in(const cv::Mat& grey, const cv::Ptr<aruco::Dictionary>& dictionary) {
  Corners corners;
  std::vector<int> ids;
  aruco::detectMarkers(grey, dictionary, corners, ids);
  return {corners, ids};
}

/// On a plane, markers lie as their board says but for what the lens bends: at most half a square.
bool lie_as_on(const aruco::CharucoBoard& board, const Corners& corners, const std::vector<int>& ids) {
  if (ids.size() < 5) return true;
  std::vector<cv::Point2f> there, here;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const std::vector<cv::Point3f>& object = marker_corners(board)[static_cast<std::size_t>(ids[i])];
    for (std::size_t k = 0; k < 4; ++k) {
      there.emplace_back(object[k].x, object[k].y);
      here.push_back(corners[i][k]);
    }
  }
  const float square = board.getSquareLength() / board.getMarkerLength() *
                       std::max(static_cast<float>(cv::norm(corners[0][1] - corners[0][0])),
                                static_cast<float>(cv::norm(corners[0][2] - corners[0][1])));
  cv::Mat agree;
  const cv::Mat found = cv::findHomography(there, here, cv::RANSAC, 0.5 * static_cast<double>(square), agree);
  return !found.empty() && cv::countNonZero(agree) >= static_cast<int>(here.size()) * 4 / 5;
}

bool determine_a_plane(const BoardCorners& corners, const Board& board) {
  constexpr std::size_t fewest = 6;
  std::set<int> rows, columns;
  for (const BoardCorner& corner : corners) {
    rows.insert(corner.number / board.columns);
    columns.insert(corner.number % board.columns);
  }
  return corners.size() >= fewest && rows.size() >= 2 && columns.size() >= 2;
}

}  // namespace

std::vector<std::string> marker_dictionaries() {
  std::vector<std::string> names;
  for (const NamedDictionary& known : dictionaries) names.emplace_back(known.name);
  return names;
}

std::optional<BoardCorners> find_charuco(const host::Raster<std::uint8_t>& picture, const Board& board,
                                         const std::string& dictionary, double marker_share) {
  host::Raster<std::uint8_t> copy = picture;
  const cv::Mat grey(picture.height, picture.width, CV_8UC1, copy.samples.data());
  const cv::Ptr<aruco::Dictionary> markers = dictionary_of(dictionary);
  const int squares = (board.columns + 1) * (board.rows + 1);
  if (squares / 2 > markers->bytesList.rows) {
    throw std::runtime_error("the dictionary " + dictionary + " has " + std::to_string(markers->bytesList.rows) +
                             " markers, fewer than the " + std::to_string(squares / 2) +
                             " white squares of the board: check --board and --charuco");
  }
  const cv::Ptr<aruco::CharucoBoard> charuco =
      board_of_squares(board.columns + 1, board.rows + 1, static_cast<float>(marker_share), markers);
  auto [corners, ids] = markers_in(grey, markers);
  if (ids.empty()) return std::nullopt;
  const int largest = *std::max_element(ids.begin(), ids.end());
  const auto of_board = static_cast<int>(marker_corners(*charuco).size());
  const std::string wanted = std::to_string(board.columns) + "x" + std::to_string(board.rows) + " inner corners";
  if (largest >= of_board) {
    throw std::runtime_error("marker " + std::to_string(largest) + " is seen, a board of " + wanted +
                             " has the markers 0 to " + std::to_string(of_board - 1) +
                             ": check --board, which counts inner corners, one fewer than squares each way");
  }
  if (!lie_as_on(*charuco, corners, ids)) {
    throw std::runtime_error("the markers lie otherwise than on a board of " + wanted +
                             ": check --board (inner corners of a row, then of a column), and keep the board flat");
  }
  std::vector<cv::Point2f> found;
  std::vector<int> numbers;
  aruco::interpolateCornersCharuco(corners, ids, grey, charuco, found, numbers);
  BoardCorners result;
  for (std::size_t i = 0; i < found.size(); ++i) result.push_back({found[i].x, found[i].y, numbers[i]});
  if (!determine_a_plane(result, board)) return std::nullopt;
  return result;
}

std::string dictionary_in(const host::Raster<std::uint8_t>& picture) {
  host::Raster<std::uint8_t> copy = picture;
  const cv::Mat grey(picture.height, picture.width, CV_8UC1, copy.samples.data());
  std::string name;
  std::size_t most = 3;
  for (const NamedDictionary& known : dictionaries) {
    const std::vector<int> ids = markers_in(grey, predefined(known.number)).second;
    const std::size_t count = std::set<int>(ids.begin(), ids.end()).size();
    if (count <= most) continue;
    most = count;
    name = known.name;
  }
  return name;
}

}  // namespace ilp::lab

#else

namespace ilp::lab {

std::vector<std::string> marker_dictionaries() {
  return {};
}

std::optional<BoardCorners> find_charuco(const host::Raster<std::uint8_t>&, const Board&, const std::string&, double) {
  throw std::runtime_error(
      "this build has no ArUco: apt-get install libopencv-contrib-dev, then cmake --preset host and build ilp-lab "
      "again");
}

std::string dictionary_in(const host::Raster<std::uint8_t>&) {
  return {};
}

}  // namespace ilp::lab

#endif
