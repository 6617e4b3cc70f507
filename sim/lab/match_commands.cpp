// overlap and match: two images.

#include <memory>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/image/overlap_workspace.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "sim/io/colmap_camera.hpp"
#include "sim/io/status_error.hpp"
#include "sim/lab/image_input.hpp"
#include "sim/lab/lab.hpp"
#include "sim/lab/number_file.hpp"

namespace ilp::lab {
namespace {

struct OverlapOptions {
  std::string a, b;
  std::string method = "ncc";
  OverlapParams params;
};

void add_search_options(CLI::App& app, OverlapOptions& options) {
  app.add_option("A", options.a, "first image, PNG or PGM")->required();
  app.add_option("B", options.b, "second image")->required();
  app.add_option("--method", options.method, "how windows are compared")->check(CLI::IsMember({"ncc", "sad"}));
  app.add_option("--max-rotation", options.params.max_rotation_rad, "rotation searched on both sides of none, rad")
      ->check(finite_in(0, 3.1416));
  app.add_option("--max-scale", options.params.max_scale, "scale searched from its inverse to it")
      ->check(finite_in(1, 1.5));
  app.add_option("--min-overlap", options.params.min_overlap, "smallest overlap that must be measurable")
      ->check(finite_in(0.1, 0.95));
}

void read_pair(const OverlapOptions& options, GrayImage& a, GrayImage& b) {
  a = read_camera_image(options.a);
  b = read_camera_image(options.b);
  require_same_size(b, options.b, a.width, a.height, options.a);
}

Json run_overlap(OverlapOptions& options, int repeat) {
  GrayImage a, b;
  read_pair(options, a, b);
  options.params.method = options.method == "sad" ? OverlapMethod::sad : OverlapMethod::ncc;
  const auto workspace = std::make_unique<OverlapWorkspace>();
  OverlapResult result;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [] {}, [&] { status = measure_overlap(a.view(), b.view(), options.params, *workspace, result); });
  sim::require(status, "overlap");
  return {{"verdict", overlap_verdict_name(result.verdict)},
          {"overlap", result.overlap},
          {"shift_px", {result.b_from_a.shift_x_px, result.b_from_a.shift_y_px}},
          {"rotation_rad", result.b_from_a.rotation_rad},
          {"scale", result.b_from_a.scale},
          {"plane_b_from_a", result.plane_b_from_a},
          {"ncc", result.ncc},
          {"ncc_second", result.ncc_second},
          {"sigma_px", result.sigma_px},
          {"method", options.method},
          {"kernel_ms", kernel_ms}};
}

struct MatchOptions {
  OverlapOptions overlap;
  std::string camera;
  std::string out;
  HarrisParams harris;
  MatcherParams matcher;
  bool guided = false;
};

struct Prediction {
  OverlapResult overlap;
  const char* source = "overlap";
};

/// As the flight predicts: the overlap check, and corner matches where correlation cannot tell.
Prediction predict(const OverlapOptions& options, GrayView a, GrayView b) {
  Prediction prediction;
  const auto workspace = std::make_unique<OverlapWorkspace>();
  sim::require(measure_overlap(a, b, options.params, *workspace, prediction.overlap), "overlap");
  if (prediction.overlap.verdict != OverlapVerdict::overlap_unknown) return prediction;
  const auto features = std::make_unique<FeatureOverlapWorkspace>();
  OverlapResult by_features;
  sim::require(measure_overlap_by_features(a, b, FeatureOverlapParams{}, *features, by_features),
               "overlap by features");
  if (by_features.verdict == OverlapVerdict::ok) prediction = {by_features, "features"};
  return prediction;
}

std::string match_lines(const Corners& corners_a, const Matches& matches) {
  std::string text = "# x_a y_a x_b y_b score, px, pixel centres at integers\n";
  for (const Match& match : matches) {
    const Corner& a = corners_a[match.a];
    char line[160];
    std::snprintf(line, sizeof(line), "%.9g %.9g %.9g %.9g %.6g\n", static_cast<double>(a.x), static_cast<double>(a.y),
                  static_cast<double>(match.xb), static_cast<double>(match.yb), static_cast<double>(match.score));
    text += line;
  }
  return text;
}

struct CornerMatching {
  HarrisWorkspace harris;
  MatcherWorkspace matcher;
  Corners corners_a, corners_b;
  Matches matches;
  std::size_t detected_b = 0;

  Status run(GrayView a, GrayView b, const double (&plane_b_from_a)[9], const MatchOptions& options) {
    ILP_TRY(detect_corners(a, options.harris, harris, corners_a));
    ILP_TRY(detect_corners(b, options.harris, harris, corners_b));
    // Corners that were followed into image b come on top of those detected there.
    detected_b = corners_b.size();
    return match_and_track_corners(a, corners_a, b, corners_b, plane_b_from_a, options.matcher, matcher, matches);
  }
};

Json run_match(const MatchOptions& options, int repeat) {
  if (options.guided) throw UsageError("--guided is not available yet: matches follow the overlap's prediction alone");
  GrayImage a, b;
  read_pair(options.overlap, a, b);
  if (!options.camera.empty()) {
    const CameraModel camera = sim::read_colmap_camera(options.camera);
    require_same_size(a, options.overlap.a, camera.width, camera.height, options.camera);
  }
  const Prediction prediction = predict(options.overlap, a.view(), b.view());
  const auto work = std::make_unique<CornerMatching>();
  Json result = {{"verdict", overlap_verdict_name(prediction.overlap.verdict)}};
  double kernel_ms = 0;
  if (prediction.overlap.verdict == OverlapVerdict::ok) {
    Status status;
    kernel_ms = time_kernel(
        repeat, [] {}, [&] { status = work->run(a.view(), b.view(), prediction.overlap.plane_b_from_a, options); });
    sim::require(status, "match");
  }
  write_text(options.out, match_lines(work->corners_a, work->matches));
  result["corners_a"] = work->corners_a.size();
  result["corners_b"] = work->detected_b;
  result["matches"] = work->matches.size();
  result["prediction"] = prediction.source;
  result["overlap"] = prediction.overlap.overlap;
  result["kernel_ms"] = kernel_ms;
  return result;
}

}  // namespace

void add_match_commands(Lab& lab) {
  const auto overlap = std::make_shared<OverlapOptions>();
  add_search_options(lab.add("overlap", "how much of A is seen again in B",
                             [overlap](int repeat) { return run_overlap(*overlap, repeat); }),
                     *overlap);

  const auto match = std::make_shared<MatchOptions>();
  CLI::App& app =
      lab.add("match", "corners of A found again in B", [match](int repeat) { return run_match(*match, repeat); });
  // Views further apart than a strip's are welcome here.
  match->overlap.params.min_overlap = 0.3;
  add_search_options(app, match->overlap);
  app.add_option("--camera", match->camera, "cameras.txt of the images: its size is checked");
  app.add_option("--corners", match->harris.target_count, "corners asked for in each image")
      ->check(CLI::Range(1, static_cast<int>(limits::max_corners)));
  app.add_option("--search-radius", match->matcher.search_radius_px, "around the predicted position, px")
      ->check(finite_in(1, 200));
  app.add_flag("--guided", match->guided, "match again along epipolar lines (not available yet)");
  app.add_option("--out", match->out, "a line x_a y_a x_b y_b score per match")->required();
}

}  // namespace ilp::lab
