// calibrate-target: calibrates a camera from pictures of a chessboard or ChArUco board, and reports the fit of each
// picture.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <memory>
#include <sstream>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/files.hpp"
#include "sim/host/photograph.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/lab/charuco_board.hpp"
#include "sim/tools/lab/lab.hpp"
#include "sim/tools/lab/target_calibration.hpp"

namespace ilp::lab {
namespace fs = std::filesystem;
namespace {

/// Fewer do not determine four distortion and four pinhole parameters with something left to check them by.
constexpr std::size_t fewest_pictures = 3;
/// Boards that are turned against each other by less say nothing about the focal length.
constexpr double least_spread_rad = 0.17;
/// Share of the focal length that its error may be.
constexpr double largest_sigma = 0.02;
/// Of the picture: corners stay in fewer of its 8 x 8 parts than this where the lens was hardly looked at.
constexpr double good_coverage = 0.5;

struct TargetOptions {
  std::vector<std::string> pictures;
  std::string board = "9x6";
  std::string charuco;  ///< dictionary of its markers; empty: a chessboard
  double marker = 0.75;
  double square = 1;
  std::string out;
  std::string picture;
};

Board board_of(const TargetOptions& options) {
  Board board;
  char rest = 0;
  if (std::sscanf(options.board.c_str(), "%dx%d%c", &board.columns, &board.rows, &rest) != 2 || board.columns < 3 ||
      board.rows < 3 || board.columns > 50 || board.rows > 50) {
    throw UsageError("--board " + options.board +
                     ": expected the inner corners of a row and of a column, such as 9x6 for 10 x 7 squares");
  }
  board.square = options.square;
  return board;
}

/// The dictionary of --charuco as marker_dictionaries() has it.
void read_dictionary(TargetOptions& options) {
  if (options.charuco.empty()) return;
  std::string wanted = options.charuco;
  if (CLI::detail::to_lower(wanted).starts_with("dict_")) wanted.erase(0, 5);
  std::string all;
  const std::vector<std::string> names = marker_dictionaries();
  for (const std::string& name : names) {
    if (CLI::detail::to_lower(name) == CLI::detail::to_lower(wanted)) {
      options.charuco = name;
      return;
    }
    all += (all.empty() ? "" : ", ") + name;
  }
  // A build without ArUco says so when it looks for the board.
  if (!names.empty())
    throw UsageError("--charuco " + options.charuco + ": expected the dictionary of the markers, one of " + all);
}

host::Raster<std::uint8_t> grey_of(const std::string& path) {
  const host::Photograph photograph = host::read_photograph(path);
  host::Raster<std::uint8_t> grey(photograph.grey.width, photograph.grey.height);
  const int divisor = photograph.deep ? 257 : 1;
  std::transform(photograph.grey.samples.begin(), photograph.grey.samples.end(), grey.samples.begin(),
                 [divisor](std::uint16_t value) { return static_cast<std::uint8_t>(value / divisor); });
  return grey;
}

struct Pictures {
  int width = 0, height = 0;
  std::vector<std::string> used, without_board;
  std::vector<BoardCorners> corners;
};

std::optional<BoardCorners> corners_in(const host::Raster<std::uint8_t>& grey, const std::string& path,
                                       const TargetOptions& options, const Board& board) {
  if (options.charuco.empty()) return find_chessboard(grey, board);
  try {
    return find_charuco(grey, board, options.charuco, options.marker);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

/// Advice for pictures in which too few boards were found.
std::string how_to_show(const TargetOptions& options, const Pictures& pictures) {
  if (options.charuco.empty()) {
    return "check --board, show the whole board with its white margin, sharp and evenly lit, from several directions";
  }
  for (const std::string& path : pictures.without_board) {
    const std::string seen = dictionary_in(grey_of(path));
    if (seen.empty() || seen == options.charuco) continue;
    return path + " shows markers of the dictionary " + seen + ": give --charuco " + seen;
  }
  return "check --charuco and --marker, show at least six inner corners with the markers around them, sharp and evenly "
         "lit, from several directions";
}

Pictures look_at(const TargetOptions& options, const Board& board) {
  Pictures pictures;
  for (const std::string& path : options.pictures) {
    const host::Raster<std::uint8_t> grey = grey_of(path);
    if (pictures.width == 0) {
      pictures.width = grey.width;
      pictures.height = grey.height;
    } else if (pictures.width != grey.width || pictures.height != grey.height) {
      throw std::runtime_error(path + " has " + host::size_text(grey.width, grey.height) + " pixels, " +
                               options.pictures.front() + " has " + host::size_text(pictures.width, pictures.height) +
                               ": give pictures of one camera at one size");
    }
    const auto corners = corners_in(grey, path, options, board);
    (corners ? pictures.used : pictures.without_board).push_back(path);
    if (corners) pictures.corners.push_back(*corners);
  }
  if (pictures.used.size() < fewest_pictures) {
    throw std::runtime_error("a board of " + options.board + " inner corners was found in " +
                             std::to_string(pictures.used.size()) + " of " +
                             host::counted(options.pictures.size(), "picture") + ", at least " +
                             std::to_string(fewest_pictures) + " are needed: " + how_to_show(options, pictures));
  }
  return pictures;
}

/// Share of the picture's 8 x 8 parts in which corners lie.
double coverage_of(const Pictures& pictures) {
  constexpr int parts = 8;
  std::vector<bool> seen(parts * parts);
  for (const BoardCorners& corners : pictures.corners) {
    for (const BoardCorner& corner : corners) {
      const int column = std::clamp(static_cast<int>((corner.x + 0.5) * parts / pictures.width), 0, parts - 1);
      const int row = std::clamp(static_cast<int>((corner.y + 0.5) * parts / pictures.height), 0, parts - 1);
      seen[static_cast<std::size_t>(row * parts + column)] = true;
    }
  }
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) / (parts * parts);
}

void check(const TargetCamera& found) {
  const Status status = validate(found.camera);
  const bool certain =
      found.sigma_fx < largest_sigma * found.camera.fx && found.sigma_fy < largest_sigma * found.camera.fy;
  if (found.normals_spread_rad >= least_spread_rad && status.ok() && certain) return;
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (found.normals_spread_rad < least_spread_rad) {
    text << "the boards are turned against each other by " << found.normals_spread_rad * 180 / 3.14159265358979323846
         << " degrees at most, at least " << least_spread_rad * 180 / 3.14159265358979323846
         << " are needed: take pictures from several directions, tilted by 20 to 45 degrees";
  } else if (!status.ok()) {
    text << "the camera that fits (focal length " << found.camera.fx
         << " px) is none that the flight takes: take more pictures, with corners near the borders of the picture";
  } else {
    text << "the focal length " << found.camera.fx << " px has a one-sigma error of " << found.sigma_fx
         << " px, more than a fiftieth: take more pictures, from more directions";
  }
  throw std::runtime_error(text.str());
}

/// Residuals as arrows at the corners, and a bar for each picture.
std::string drawing(const Pictures& pictures, const TargetCamera& found) {
  const double width = 720, scale = width / pictures.width, height = scale * pictures.height;
  const double largest = std::max(found.rms_px, 1e-3);
  const double magnified = 15 / largest;  // an arrow of the usual residual is 15 units long
  const double bar = 14, top = height + 60;
  const auto count = static_cast<double>(found.views.size());
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(2);
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"760\" height=\"" << top + bar * count + 20
      << "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  svg << "<text x=\"20\" y=\"16\">residuals of the corners, px x " << magnified / scale << "; root mean square "
      << std::setprecision(3) << found.rms_px << " px</text>\n"
      << std::setprecision(2);
  svg << "<rect x=\"20\" y=\"24\" width=\"" << width << "\" height=\"" << height
      << "\" fill=\"none\" stroke=\"#666666\"/>\n<path fill=\"none\" stroke=\"#1f5fa8\" d=\"";
  for (std::size_t i = 0; i < found.views.size(); ++i) {
    for (std::size_t k = 0; k < found.views[i].residuals.size(); ++k) {
      const BoardCorner &at = pictures.corners[i][k], &off = found.views[i].residuals[k];
      svg << "M" << 20 + scale * (at.x + 0.5) << " " << 24 + scale * (at.y + 0.5) << "l" << magnified * off.x << " "
          << magnified * off.y;
    }
  }
  svg << "\"/>\n<text x=\"20\" y=\"" << top - 12 << "\">root mean square of each picture, px</text>\n";
  double longest = 0;
  for (const TargetView& view : found.views) longest = std::max(longest, view.rms_px);
  for (std::size_t i = 0; i < found.views.size(); ++i) {
    const double y = top + bar * static_cast<double>(i);
    const double length = longest > 0 ? 260 * found.views[i].rms_px / longest : 0;
    svg << "<rect x=\"20\" y=\"" << y << "\" width=\"" << length << "\" height=\"" << bar - 3
        << "\" fill=\"#1f5fa8\"/><text x=\"" << 26 + length << "\" y=\"" << y + bar - 4 << "\">" << std::setprecision(3)
        << found.views[i].rms_px << std::setprecision(2) << " "
        << host::escaped(fs::path(pictures.used[i]).filename().string()) << "</text>\n";
  }
  svg << "</svg>\n";
  return svg.str();
}

Json run_calibrate_target(TargetOptions options, int repeat) {
  read_dictionary(options);
  const Board board = board_of(options);
  const Pictures pictures = look_at(options, board);
  TargetCamera found;
  const double kernel_ms = time_kernel(
      repeat, [] {}, [&] { found = calibrate_by_boards(pictures.corners, board, pictures.width, pictures.height); });
  check(found);
  if (!options.out.empty()) host::write_colmap_camera(options.out, found.camera);
  if (!options.picture.empty()) host::update_file(options.picture, drawing(pictures, found));
  const double coverage = coverage_of(pictures);
  Json views = Json::array();
  for (std::size_t i = 0; i < found.views.size(); ++i) {
    views.push_back({{"picture", pictures.used[i]},
                     {"corners", pictures.corners[i].size()},
                     {"rms_px", found.views[i].rms_px},
                     {"tilt_deg", found.views[i].tilt_rad * 180 / 3.14159265358979323846}});
  }
  Json result = {{"width", pictures.width},    {"height", pictures.height},  {"fx", found.camera.fx},
                 {"fy", found.camera.fy},      {"cx", found.camera.cx},      {"cy", found.camera.cy},
                 {"k1", found.camera.k1},      {"k2", found.camera.k2},      {"p1", found.camera.p1},
                 {"p2", found.camera.p2},      {"sigma_fx", found.sigma_fx}, {"sigma_fy", found.sigma_fy},
                 {"sigma_cx", found.sigma_cx}, {"sigma_cy", found.sigma_cy}, {"rms_px", found.rms_px},
                 {"coverage", coverage},       {"pictures", views},          {"without_board", pictures.without_board},
                 {"kernel_ms", kernel_ms}};
  if (coverage < good_coverage) {
    result["advice"] =
        "the corners lie in " + host::fixed(100 * coverage, 0) +
        " % of the picture only: show the board near its borders and corners too, so that the distortion "
        "there is known";
  }
  return result;
}

}  // namespace

void add_calibrate_target_command(Lab& lab) {
  const auto options = std::make_shared<TargetOptions>();
  CLI::App& app = lab.add(
      "calibrate-target", "the camera, from pictures of a chessboard or ChArUco board, with its residuals",
      "*.jpg --board 9x6 --out cameras.txt", [options](int repeat) { return run_calibrate_target(*options, repeat); });
  app.add_option("PICTURE", options->pictures, "pictures of the board by one camera: JPEG, TIFF, PNG or PGM")
      ->required();
  app.add_option("--board", options->board,
                 "inner corners of the board's rows and columns: 9x6 is a board of 10 x 7 squares");
  app.add_option("--charuco", options->charuco,
                 "dictionary of the markers of a ChArUco board, such as 5X5_100; it may be seen in part");
  app.add_option("--marker", options->marker, "ratio of the side of a marker to that of a square")
      ->check(finite_in(0.2, 0.98));
  app.add_option("--square", options->square, "side of a square, in any unit; the camera does not depend on it")
      ->check(finite_in(1e-6, 1e6));
  app.add_option("--out", options->out, "cameras.txt to write");
  app.add_option("--picture", options->picture, "SVG picture of the residuals to write");
}

}  // namespace ilp::lab
