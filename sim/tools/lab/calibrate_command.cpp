// calibrate: the intrinsics of the camera that took a few images, or the reason why they cannot be found.

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "fsw/vision/calibration/self_calibration.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace fs = std::filesystem;
namespace {

struct CalibrateOptions {
  std::vector<std::string> images;
  std::string matches;
  std::string camera;
  std::vector<int> size;
  std::string out;
  CalibrationParams params;
  std::uint64_t seed = 1;
};

/// What the kernel is fed with.
struct CalibrationInput {
  std::string name;
  Corners corners;
  Matches matches;  ///< to the previous image
};

/// The focal length is only a nominal value: see SelfCalibration::begin.
CameraModel camera_of_size(int width, int height) {
  return centred_camera(width, height, width);
}

class ImageMatching {
 public:
  /// As the flight does it: the overlap check predicts, corners are found again or followed.
  void add(const std::string& path, std::vector<CalibrationInput>& inputs) {
    GrayImage image = read_camera_image(path);
    CalibrationInput input{path, {}, {}};
    host::require(detect_corners(image.view(), HarrisParams{}, harris_, input.corners), "corners of " + path);
    if (!inputs.empty()) {
      require_same_size(image, path, previous_.width, previous_.height, inputs.front().name);
      double plane[9];
      if (predict(image.view(), path, plane)) {
        host::require(match_and_track_corners(previous_.view(), corners_, image.view(), input.corners, plane,
                                              MatcherParams{}, matcher_, input.matches),
                      "matching " + path);
      }
    }
    corners_ = input.corners;
    refine_corners(input.matches, corners_);
    previous_ = std::move(image);
    inputs.push_back(input);
  }
  [[nodiscard]] int width() const { return previous_.width; }
  [[nodiscard]] int height() const { return previous_.height; }

 private:
  bool predict(GrayView image, const std::string& path, double (&plane)[9]) {
    OverlapParams params;
    params.min_overlap = 0.3;
    OverlapResult overlap;
    host::require(measure_overlap(previous_.view(), image, params, overlap_, overlap), "overlap of " + path);
    if (overlap.verdict == OverlapVerdict::overlap_unknown) {
      host::require(
          measure_overlap_by_features(previous_.view(), image, FeatureOverlapParams{}, feature_overlap_, overlap),
          "overlap by features of " + path);
    }
    std::copy(std::begin(overlap.plane_b_from_a), std::end(overlap.plane_b_from_a), plane);
    return overlap.verdict == OverlapVerdict::ok;
  }

  GrayImage previous_;
  Corners corners_;
  HarrisWorkspace harris_;
  MatcherWorkspace matcher_;
  OverlapWorkspace overlap_;
  FeatureOverlapWorkspace feature_overlap_;
};

std::vector<CalibrationInput> inputs_from_images(const CalibrateOptions& options, CameraModel& nominal) {
  std::vector<CalibrationInput> inputs;
  const auto matching = std::make_unique<ImageMatching>();
  for (const std::string& path : options.images) matching->add(path, inputs);
  if (options.camera.empty()) {
    nominal = camera_of_size(matching->width(), matching->height());
  } else if (nominal.width != matching->width() || nominal.height != matching->height()) {
    throw std::runtime_error(options.images.front() + " has not the size that " + options.camera + " says");
  }
  return inputs;
}

std::uint16_t corner_at(const std::string& path, const CameraModel& nominal, double x, double y,
                        std::map<std::pair<float, float>, std::uint16_t>& known, Corners& corners) {
  if (!(x >= -0.5 && x <= nominal.width - 0.5 && y >= -0.5 && y <= nominal.height - 0.5)) {
    throw std::runtime_error(path + ": (" + exact_text(x) + ", " + exact_text(y) + ") is outside an image of " +
                             std::to_string(nominal.width) + " x " + std::to_string(nominal.height) + " px");
  }
  const std::pair<float, float> place(static_cast<float>(x), static_cast<float>(y));
  const auto [at, fresh] = known.try_emplace(place, static_cast<std::uint16_t>(corners.size()));
  if (fresh && !corners.push_back({place.first, place.second, 1})) {
    throw std::runtime_error(path + ": more than " + std::to_string(limits::max_corners) +
                             " points in an image (limits::max_corners)");
  }
  return at->second;
}

/// Files in the order of their names, each between an image and the next. A point goes on where the x_a y_a of a line
/// is the x_b y_b of a line in the file before.
std::vector<CalibrationInput> inputs_from_matches(const std::string& folder, const CameraModel& nominal) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) throw std::runtime_error(folder + ": no such folder");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".txt") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) throw std::runtime_error(folder + ": no matches, files *.txt of lines x_a y_a x_b y_b [score]");
  std::vector<CalibrationInput> inputs(files.size() + 1);
  std::map<std::pair<float, float>, std::uint16_t> known;
  const auto pairs = std::make_unique<PointPairs>();
  for (std::size_t i = 0; i < files.size(); ++i) {
    inputs[i + 1].name = files[i].string();
    read_matches(files[i], *pairs);
    std::map<std::pair<float, float>, std::uint16_t> next;
    std::vector<bool> used_a(limits::max_corners), used_b(limits::max_corners);
    for (const PointPair& pair : *pairs) {
      Match match;
      match.a = corner_at(inputs[i + 1].name, nominal, pair.xa, pair.ya, known, inputs[i].corners);
      match.b = corner_at(inputs[i + 1].name, nominal, pair.xb, pair.yb, next, inputs[i + 1].corners);
      match.score = pair.quality;
      match.xb = static_cast<float>(pair.xb);
      match.yb = static_cast<float>(pair.yb);
      // If a point has several matches, the first counts.
      if (used_a[match.a] || used_b[match.b]) continue;
      used_a[match.a] = used_b[match.b] = true;
      static_cast<void>(inputs[i + 1].matches.push_back(match));
    }
    known = std::move(next);
  }
  return inputs;
}

Json pair_of(const CalibrationPair& pair) {
  return {{"verdict", name_of(pair.verdict)},
          {"matches", pair.matches},
          {"inliers", pair.inliers},
          {"gric_f", pair.gric_f},
          {"gric_h", pair.gric_h},
          {"motion_px", pair.motion_px}};
}

/// Tries all sets and takes the first that answers, otherwise the last.
Status calibrate(const std::vector<CalibrationInput>& inputs, const CameraModel& nominal,
                 const CalibrationParams& params, SelfCalibration& calibration, CalibrationReport& report) {
  ILP_TRY(calibration.begin(nominal, params));
  CalibrationReport newest;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    ILP_TRY(calibration.add_keyframe(static_cast<std::int64_t>(i), inputs[i].corners, inputs[i].matches, i, newest));
    // The reason why the previous set was refused says more than that this set is not complete yet.
    const bool says_more = newest.verdict != CalibrationVerdict::collecting;
    if (says_more || i == 0) report = newest;
    if (newest.verdict == CalibrationVerdict::ok) break;
  }
  return {};
}

Json run_calibrate(CalibrateOptions& options, int repeat) {
  if (options.images.empty() == options.matches.empty()) throw UsageError("give images, or --matches and a folder");
  if (!options.matches.empty() && options.camera.empty() && options.size.empty()) {
    throw UsageError("--matches needs the size of the images: --size W H, or --camera");
  }
  if (!options.size.empty() && (options.matches.empty() || !options.camera.empty())) {
    throw UsageError("--size goes with --matches and without --camera");
  }
  if (options.params.min_field_of_view_rad >= options.params.max_field_of_view_rad) {
    throw UsageError("--min-field must be below --max-field");
  }
  CameraModel nominal;
  if (!options.camera.empty()) nominal = host::read_global_shutter_camera(options.camera);
  if (options.camera.empty() && !options.size.empty()) nominal = camera_of_size(options.size[0], options.size[1]);
  const std::vector<CalibrationInput> inputs =
      options.matches.empty() ? inputs_from_images(options, nominal) : inputs_from_matches(options.matches, nominal);
  options.params.pair.seed = options.seed;
  if (options.params.min_views > options.params.max_views) options.params.max_views = options.params.min_views;

  const auto state = std::make_unique<CalibrationState>();
  const auto workspace = std::make_unique<CalibrationWorkspace>();
  SelfCalibration calibration(*state, *workspace);
  CalibrationReport report;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [] {}, [&] { status = calibrate(inputs, nominal, options.params, calibration, report); });
  host::require(status, "calibrate");
  const bool ok = report.verdict == CalibrationVerdict::ok;
  const auto if_ok = [ok](double value) { return ok ? Json(value) : Json(); };
  Json pairs = Json::array();
  for (const CalibrationPair& pair : report.pairs) pairs.push_back(pair_of(pair));
  if (ok && !options.out.empty()) host::write_colmap_camera(options.out, report.camera);
  return {{"verdict", name_of(report.verdict)},
          {"reason", words_of(report.verdict)},
          {"fx", if_ok(report.camera.fx)},
          {"fy", if_ok(report.camera.fy)},
          {"cx", if_ok(report.camera.cx)},
          {"cy", if_ok(report.camera.cy)},
          {"sigma_fx", if_ok(report.sigma_focal_px)},
          {"sigma_fy", if_ok(report.sigma_focal_px * report.camera.fy / (report.camera.fx > 0 ? report.camera.fx : 1))},
          {"sigma_cx", if_ok(report.sigma_cx_px)},
          {"sigma_cy", if_ok(report.sigma_cy_px)},
          {"images", inputs.size()},
          {"views", report.views},
          {"points", report.points},
          {"observations", report.observations},
          {"noise_px", report.noise_px},
          {"axes_spread_rad", report.axes_spread_rad},
          {"consistency", report.consistency},
          {"start_focal_px", report.start_focal_px},
          {"refined_focal_px", report.refined_focal_px},
          {"refined_sigma_px", report.refined_sigma_px},
          {"pairs", pairs},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_calibrate_command(Lab& lab) {
  const auto options = std::make_shared<CalibrateOptions>();
  CLI::App& app = lab.add("calibrate",
                          "focal length and principal point from images alone, or why the images do not determine them",
                          [options](int repeat) { return run_calibrate(*options, repeat); });
  app.add_option("IMAGE", options->images, "images of one camera in the order of the flight; each overlaps the next");
  app.add_option(
      "--matches", options->matches,
      "instead of images: a folder of files *.txt, with a line x_a y_a x_b y_b [score] per match of an image with "
      "the next; equal coordinates in two files are one point");
  app.add_option("--size", options->size, "width and height in px of the images that were matched")
      ->expected(2)
      ->check(CLI::Range(limits::min_image_side, 100000));
  app.add_option("--camera", options->camera,
                 "cameras.txt with size, distortion and expected principal point; its focal length is not used");
  app.add_option("--seed", options->seed, "seed of the random samples");
  app.add_option("--views", options->params.min_views, "least number of images of a set")
      ->check(CLI::Range(3, static_cast<int>(limits::max_calibration_views)));
  app.add_option("--min-field", options->params.min_field_of_view_rad, "least horizontal field of view, rad")
      ->check(finite_in(0.1, 2.9));
  app.add_option("--max-field", options->params.max_field_of_view_rad, "greatest horizontal field of view, rad")
      ->check(finite_in(0.1, 2.9));
  app.add_option("--out", options->out, "cameras.txt to write when the camera is found");
}

}  // namespace ilp::lab
