// relpose, fundamental, homography: estimate the geometry of two views from a list of matches.

#include <array>
#include <memory>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/twoview/robust/robust_models.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "sim/host/camera_file.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct TwoViewOptions {
  std::string matches;
  std::string camera, camera_b;
  RansacParams params;
};

struct TwoViewData {
  TwoViewWorkspace workspace;
  PointPairs pairs;
  InlierMask inliers;
};

void add_ransac_options(CLI::App& app, TwoViewOptions& options) {
  app.add_option("M", options.matches,
                 "file of matches, a line x_a y_a x_b y_b [score] each; better scores are tried first")
      ->required();
  app.add_option("--seed", options.params.seed, "seed of the random samples");
  app.add_option("--threshold", options.params.threshold_px, "inlier threshold, px")->check(finite_in(0.01, 100));
  app.add_option("--max-trials", options.params.max_trials, "largest number of samples")
      ->check(CLI::Range(1, static_cast<int>(limits::max_ransac_trials)));
}

void remove_distortion(const CameraModel& camera_a, const CameraModel& camera_b, PointPairs& pairs) {
  for (PointPair& pair : pairs) {
    const Vec2 a = ideal_from_pixel(camera_a, {pair.xa, pair.ya});
    const Vec2 b = ideal_from_pixel(camera_b, {pair.xb, pair.yb});
    pair.xa = a.x();
    pair.ya = a.y();
    pair.xb = b.x();
    pair.yb = b.y();
  }
}

Json rows_of(const Mat3& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2)});
  return rows;
}

Json json_of(const PlaneSolution& solution) {
  const PlaneMotion& motion = solution.motion;
  double q[4];
  quaternion_from_rotation(motion.b_from_a.rotation, q);
  const Vec3& t = motion.b_from_a.translation;
  return {{"rotation_b_from_a", {q[0], q[1], q[2], q[3]}},
          {"direction_b", {t.x(), t.y(), t.z()}},
          {"plane_a_per_baseline", {motion.plane.x(), motion.plane.y(), motion.plane.z()}},
          {"support", solution.support}};
}

Json run_relpose(const TwoViewOptions& options, int repeat) {
  const auto data = std::make_unique<TwoViewData>();
  const CameraModel camera_a = host::read_global_shutter_camera(options.camera);
  const CameraModel camera_b = options.camera_b.empty() ? camera_a : host::read_global_shutter_camera(options.camera_b);
  read_matches(options.matches, data->pairs);
  remove_distortion(camera_a, camera_b, data->pairs);
  TwoViewResult result;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [&] { result = {}; },
      [&] {
        status =
            estimate_two_view(data->pairs, camera_a, camera_b, options.params, data->workspace, data->inliers, result);
      });
  const std::string failure = verdict_of(status, "relpose");
  const std::string verdict = status.ok() ? name_of(result.verdict) : failure;
  const bool has_pose = status.ok() && result.verdict != TwoViewVerdict::too_few_inliers;
  Json rotation, direction;
  if (has_pose) {
    double q[4];
    quaternion_from_rotation(result.b_from_a.rotation, q);
    rotation = {q[0], q[1], q[2], q[3]};
    const Vec3& t = result.b_from_a.translation;
    direction = {t.x(), t.y(), t.z()};
  }
  Json planes = Json::array();
  for (std::size_t k = 0; k < result.planes.count; ++k) planes.push_back(json_of(result.planes.solution[k]));
  return {{"verdict", verdict},
          {"rotation_b_from_a", rotation},
          {"direction_b", direction},
          {"matches", data->pairs.size()},
          {"inliers", result.inliers},
          {"gric_e", result.gric_e},
          {"gric_h", result.gric_h},
          {"median_parallax_px", result.median_parallax_px},
          {"rms_px", result.rms_px},
          {"sigma_rotation_rad", result.sigma_rotation_rad},
          {"sigma_direction_rad", result.sigma_direction_rad},
          {"planes", planes},
          {"kernel_ms", kernel_ms}};
}

template <typename Result, typename Estimate>
Json run_model(const TwoViewOptions& options, int repeat, const char* name, const Mat3 Result::*matrix,
               Estimate estimate) {
  const auto data = std::make_unique<TwoViewData>();
  read_matches(options.matches, data->pairs);
  Result result;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [&] { result = {}; },
      [&] { status = estimate(data->pairs, options.params, data->workspace, data->inliers, result); });
  const std::string failure = verdict_of(status, name);
  const std::string verdict = !status.ok() ? failure : result.found ? "ok" : "no_model";
  return {{"verdict", verdict},
          {name, verdict == "ok" ? rows_of(result.*matrix) : Json()},
          {"matches", data->pairs.size()},
          {"inliers", result.inliers},
          {"gric", result.gric},
          {"rms_px", result.rms_px},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_two_view_commands(Lab& lab) {
  const auto relpose = std::make_shared<TwoViewOptions>();
  CLI::App& app =
      lab.add("relpose", "relative pose of two calibrated views from matches in pixels of the real images",
              "matches.txt --camera cameras.txt", [relpose](int repeat) { return run_relpose(*relpose, repeat); });
  add_ransac_options(app, *relpose);
  app.add_option("--camera", relpose->camera, "cameras.txt of image a, and of image b without --camera-b")->required();
  app.add_option("--camera-b", relpose->camera_b, "cameras.txt of image b");

  const auto fundamental = std::make_shared<TwoViewOptions>();
  add_ransac_options(
      lab.add("fundamental", "fundamental matrix b^T F a = 0 from matches without distortion", "matches.txt",
              [fundamental](int repeat) {
                return run_model(*fundamental, repeat, "fundamental", &FundamentalResult::fundamental,
                                 estimate_fundamental);
              }),
      *fundamental);

  const auto homography = std::make_shared<TwoViewOptions>();
  add_ransac_options(lab.add("homography", "homography b ~ H a from matches without distortion", "matches.txt",
                             [homography](int repeat) {
                               return run_model(*homography, repeat, "homography", &HomographyResult::homography,
                                                estimate_homography);
                             }),
                     *homography);
}

}  // namespace ilp::lab
