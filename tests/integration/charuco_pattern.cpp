#include "tests/integration/charuco_pattern.hpp"

#ifdef ILP_HAVE_OPENCV_ARUCO

#include <opencv2/aruco/charuco.hpp>

namespace ilp::test {

std::optional<host::Raster<std::uint8_t>> charuco_pattern(int columns, int rows, const std::string& dictionary,
                                                          int px) {
  const auto markers =
      cv::aruco::getPredefinedDictionary(dictionary == "4X4_50" ? cv::aruco::DICT_4X4_50 : cv::aruco::DICT_5X5_100);
  cv::Mat drawn;
  const cv::Size size((columns + 1) * px, (rows + 1) * px);
#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 407
  cv::aruco::CharucoBoard board({columns + 1, rows + 1}, 1.0F, 0.75F, markers);
  board.setLegacyPattern(true);
  board.generateImage(size, drawn, 0, 1);
#else
  cv::aruco::CharucoBoard::create(columns + 1, rows + 1, 1.0F, 0.75F, markers)->draw(size, drawn, 0, 1);
#endif
  host::Raster<std::uint8_t> pattern(drawn.cols, drawn.rows);
  for (int y = 0; y < drawn.rows; ++y) std::copy_n(drawn.ptr<std::uint8_t>(y), drawn.cols, &pattern.at(0, y));
  return pattern;
}

}  // namespace ilp::test

#else

namespace ilp::test {

std::optional<host::Raster<std::uint8_t>> charuco_pattern(int, int, const std::string&, int) {
  return std::nullopt;
}

}  // namespace ilp::test

#endif
