// overlap, match: measure the overlap of two images, and match their corners.

#include <memory>

#include "cfg/mission.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/place/place_overlap.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "fsw/vision/twoview/feature_overlap.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct OverlapOptions {
  std::string a, b;
  std::string method = "ncc";
  OverlapParams params;
};

void add_search_options(CLI::App& app, OverlapOptions& options) {
  app.add_option("A", options.a, "first image: PNG, PGM, JPEG or TIFF")->required();
  app.add_option("B", options.b, "second image")->required();
  app.add_option("--method", options.method, "how windows are compared")->check(CLI::IsMember({"ncc", "sad"}));
  app.add_option("--max-rotation", options.params.max_rotation_rad,
                 "largest rotation that is searched, rad, in both directions")
      ->check(finite_in(0, 3.1416));
  app.add_option("--max-scale", options.params.max_scale, "largest scale that is searched; its inverse is the smallest")
      ->check(finite_in(1, 1.5));
  app.add_option("--min-overlap", options.params.min_overlap,
                 "smallest overlap that must be measurable, as a share of the image")
      ->check(finite_in(0.1, 0.95));
}

std::string pair_of(const OverlapOptions& options) {
  return options.a + " and " + options.b;
}

struct Relation {
  OverlapResult overlap;
  const char* source = "overlap";
  double correlation_ms = 0;
};

/// As the overlap checker relates the second image of a flight to the first one: by correlation, by corner matches
/// where that is weak, and by oriented features where neither gives an answer.
Relation relate(const OverlapOptions& options, GrayView a, GrayView b, int repeat) {
  Relation relation;
  OverlapResult& overlap = relation.overlap;
  const auto workspace = std::make_unique<OverlapWorkspace>();
  Status status;
  relation.correlation_ms = time_kernel(
      repeat, [] {}, [&] { status = measure_overlap(a, b, options.params, *workspace, overlap); });
  host::require(status, "overlap of " + pair_of(options));
  const auto unknown = [&] { return overlap.verdict == OverlapVerdict::overlap_unknown; };
  const auto take = [&](const OverlapResult& found, const char* source) {
    if (found.verdict != OverlapVerdict::ok) return;
    overlap = found;
    relation.source = source;
  };
  OverlapResult found;
  if (unknown() || (overlap.verdict == OverlapVerdict::ok && overlap.ncc < weak_correlation)) {
    const std::uint64_t seed = mix64(MissionParameters{}.seed) ^ 2U;  // of the second frame
    const auto features = std::make_unique<FeatureOverlapWorkspace>();
    host::require(measure_overlap_by_features(a, b, seed, *features, found),
                  "overlap by corners of " + pair_of(options));
    take(found, "features");
  }
  if (!unknown()) return relation;
  const auto places = std::make_unique<PlaceScratch>();
  host::require(measure_overlap_by_places(a, b, limits::max_place_features, *places, found),
                "overlap by oriented features of " + pair_of(options));
  take(found, "places");
  return relation;
}

Json run_overlap(OverlapOptions& options, int repeat) {
  // Large photographs have joined pixels, as in a flight.
  const StripImages images({options.a, options.b});
  const GrayImage a = images.read(options.a), b = images.read(options.b);
  require_same_size(b, options.b, a.width, a.height, options.a);
  options.params.method = options.method == "sad" ? OverlapMethod::sad : OverlapMethod::ncc;
  const Relation relation = relate(options, a.view(), b.view(), repeat);
  const OverlapResult& result = relation.overlap;
  return {{"verdict", name_of(result.verdict)},
          {"source", relation.source},
          {"binning", images.binning()},
          {"overlap", result.overlap},
          {"shift_px", {result.b_from_a.shift_x_px, result.b_from_a.shift_y_px}},
          {"rotation_rad", result.b_from_a.rotation_rad},
          {"scale", result.b_from_a.scale},
          {"plane_b_from_a", result.plane_b_from_a},
          {"ncc", result.ncc},
          {"ncc_second", result.ncc_second},
          {"sigma_px", result.sigma_px},
          {"method", options.method},
          {"kernel_ms", relation.correlation_ms}};
}

struct MatchOptions {
  OverlapOptions overlap;
  std::string out;
  HarrisParams harris;
  MatcherParams matcher;
};

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
  const GrayImage a = read_camera_image(options.overlap.a), b = read_camera_image(options.overlap.b);
  require_same_size(b, options.overlap.b, a.width, a.height, options.overlap.a);
  const Relation prediction = relate(options.overlap, a.view(), b.view(), 1);
  const auto& plane = prediction.overlap.plane_b_from_a;
  const auto work = std::make_unique<CornerMatching>();
  double kernel_ms = 0;
  if (prediction.overlap.verdict == OverlapVerdict::ok) {
    Status status;
    kernel_ms = time_kernel(
        repeat, [] {}, [&] { status = work->run(a.view(), b.view(), plane, options); });
    host::require(status, "match of " + pair_of(options.overlap));
  }
  write_text(options.out, match_lines(work->corners_a, work->matches));
  return {{"verdict", name_of(prediction.overlap.verdict)},
          {"corners_a", work->corners_a.size()},
          {"corners_b", work->detected_b},
          {"matches", work->matches.size()},
          {"prediction", prediction.source},
          {"overlap", prediction.overlap.overlap},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_match_commands(Lab& lab) {
  const auto overlap = std::make_shared<OverlapOptions>();
  add_search_options(lab.add("overlap", "how much of A is seen again in B", "0001.png 0002.png",
                             [overlap](int repeat) { return run_overlap(*overlap, repeat); }),
                     *overlap);

  const auto match = std::make_shared<MatchOptions>();
  CLI::App& app = lab.add("match", "corners of A found again in B", "0001.png 0002.png --out matches.txt",
                          [match](int repeat) { return run_match(*match, repeat); });
  // Views further apart than a strip's are welcome here.
  match->overlap.params.min_overlap = 0.3;
  add_search_options(app, match->overlap);
  app.add_option("--corners", match->harris.target_count, "number of corners wanted in each image")
      ->check(CLI::Range(1, static_cast<int>(limits::max_corners)));
  app.add_option("--search-radius", match->matcher.search_radius_px, "search radius around the predicted position, px")
      ->check(finite_in(1, 200));
  app.add_option("--out", match->out, "file to write: a line x_a y_a x_b y_b score per match")->required();
}

}  // namespace ilp::lab
