// bundle: solves one window of bundle adjustment.

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"
#include "sim/tools/lab/sparse_problem.hpp"

namespace ilp::lab {
namespace {

// The text form of one window of bundle adjustment:
//   ncam npts nobs
//   fx fy cx cy
//   cam pt u v                  nobs lines, ideal px
//   fixed rx ry rz tx ty tz     ncam lines, x_cam = R X + t with R the rotation of |r| rad about r
//   X Y Z                       npts lines

struct Sizes {
  std::uint32_t cameras = 0, points = 0, observations = 0;
};

std::uint32_t read_size(const NumberFile& file, double number, const char* name, std::size_t limit,
                        const char* limit_name) {
  constexpr double largest_count = 1e9;
  const std::uint32_t size = file.whole(number, name, largest_count);
  if (size == 0) file.fail(std::string("no ") + name);
  if (size > limit) {
    file.fail(std::to_string(size) + " " + name + ", the limit of the flight software is " + std::to_string(limit) +
              " (limits::" + limit_name + " in cfg/limits.hpp)");
  }
  return size;
}

Sizes read_sizes(NumberFile& file) {
  std::vector<double> n;
  file.expect(3, "ncam npts nobs", n);
  return {read_size(file, n[0], "cameras", limits::max_bundle_cameras, "max_bundle_cameras"),
          read_size(file, n[1], "points", limits::max_bundle_points, "max_bundle_points"),
          read_size(file, n[2], "observations", limits::max_bundle_observations, "max_bundle_observations")};
}

BundleCamera read_intrinsics(NumberFile& file) {
  std::vector<double> n;
  file.expect(4, "fx fy cx cy", n);
  if (!(n[0] > 0) || !(n[1] > 0)) file.fail("focal lengths must be positive");
  BundleCamera camera;
  camera.fx = n[0];
  camera.fy = n[1];
  camera.cx = n[2];
  camera.cy = n[3];
  return camera;
}

void read_observation(NumberFile& file, const Sizes& sizes, BundleProblem& problem) {
  std::vector<double> n;
  file.expect(4, "cam pt u v", n);
  const auto camera = static_cast<std::uint16_t>(file.whole(n[0], "camera", sizes.cameras));
  const auto point = static_cast<std::uint16_t>(file.whole(n[1], "point", sizes.points));
  if (!problem.observations.push_back({camera, point, n[2], n[3]})) file.fail("too many observations");
}

void read_camera(NumberFile& file, BundleCamera camera, BundleProblem& problem) {
  std::vector<double> n;
  file.expect(7, "fixed rx ry rz tx ty tz", n);
  camera.fixed = file.whole(n[0], "the mark for a fixed camera", 2) == 1;
  constexpr double largest_angle = 1e4;
  const Vec3 rotation(n[1], n[2], n[3]);
  if (!(rotation.norm() < largest_angle)) file.fail("the rotation is no angle-axis vector in rad");
  camera.pose = pose_from({rotation_from_vector(rotation), Vec3(n[4], n[5], n[6])});
  if (!problem.cameras.push_back(camera)) file.fail("too many cameras");
}

void read_point(NumberFile& file, BundleProblem& problem) {
  std::vector<double> n;
  file.expect(3, "X Y Z", n);
  if (!problem.points.push_back({{n[0], n[1], n[2]}})) file.fail("too many points");
}

void append_line(std::string& text, std::string first, std::initializer_list<double> numbers) {
  text += first;
  for (const double number : numbers) {
    if (!first.empty()) text += ' ';
    text += exact_text(number);
    first = " ";
  }
  text += '\n';
}

/// std::runtime_error names line and cause; sizes over the flight limits are refused with the limit's name.
void read_window(const std::filesystem::path& path, BundleProblem& problem) {
  NumberFile file("window file", path);
  const Sizes sizes = read_sizes(file);
  const BundleCamera intrinsics = read_intrinsics(file);
  problem.cameras.clear();
  problem.points.clear();
  problem.observations.clear();
  for (std::uint32_t i = 0; i < sizes.observations; ++i) read_observation(file, sizes, problem);
  for (std::uint32_t i = 0; i < sizes.cameras; ++i) read_camera(file, intrinsics, problem);
  for (std::uint32_t i = 0; i < sizes.points; ++i) read_point(file, problem);
  std::vector<double> rest;
  if (file.next(rest)) file.fail("the window ended before this line");
}

void write_window(const std::filesystem::path& path, const BundleProblem& problem) {
  std::string text = "# ncam npts nobs; fx fy cx cy; cam pt u v; fixed rx ry rz tx ty tz; X Y Z\n";
  text += std::to_string(problem.cameras.size()) + " " + std::to_string(problem.points.size()) + " " +
          std::to_string(problem.observations.size()) + "\n";
  const BundleCamera& first = problem.cameras[0];
  append_line(text, "", {first.fx, first.fy, first.cx, first.cy});
  for (const BundleObservation& o : problem.observations) {
    append_line(text, std::to_string(o.camera) + " " + std::to_string(o.point), {o.x, o.y});
  }
  for (const BundleCamera& camera : problem.cameras) {
    const RigidTransform pose = cam_from_world(camera.pose);
    const Vec3 r = vector_from_rotation(pose.rotation);
    const Vec3& t = pose.translation;
    append_line(text, camera.fixed ? "1" : "0", {r.x(), r.y(), r.z(), t.x(), t.y(), t.z()});
  }
  for (const BundlePoint& point : problem.points) {
    append_line(text, "", {point.position[0], point.position[1], point.position[2]});
  }
  write_text(path, text);
}

struct BundleOptions {
  std::string window, out;
  std::vector<std::uint32_t> cameras;  ///< first and count; empty: all
  BundleParams params;
};

/// A window, or one of a problem in the form of others.
struct BundleInput {
  BundleProblem bundle;
  std::optional<SparseWindow> sparse;
};

void read_input(const BundleOptions& options, BundleInput& input) {
  const bool is_folder = std::filesystem::is_directory(options.window);
  if (is_folder || is_bal(options.window)) {
    const SparseProblem problem = is_folder ? read_colmap_problem(options.window) : read_bal(options.window);
    const CameraRange range =
        options.cameras.empty() ? CameraRange{} : CameraRange{options.cameras[0], options.cameras[1]};
    input.sparse = choose_window(problem, range);
    make_bundle(input.sparse->problem, input.bundle);
    return;
  }
  if (!options.cameras.empty()) throw UsageError("--cameras chooses from a BAL file or a COLMAP model");
  read_window(options.window, input.bundle);
}

Json run_bundle(const BundleOptions& options, int repeat) {
  const auto input = std::make_unique<BundleInput>();
  const auto problem = std::make_unique<BundleProblem>();
  const auto adjuster = std::make_unique<BundleAdjuster>();
  read_input(options, *input);
  BundleResult result;
  Status status;
  const double kernel_ms = time_kernel(
      repeat,
      [&] {
        *problem = input->bundle;
        result = {};
      },
      [&] { status = adjuster->run(*problem, options.params, result); });
  const std::string failure = verdict_of(status, "bundle");
  if (status.ok() && input->sparse) {
    take_bundle(*problem, input->sparse->problem);
    write_problem(input->sparse->problem, options.out);
  } else if (status.ok()) {
    write_window(options.out, *problem);
  }
  return {{"verdict", !status.ok()       ? failure
                      : result.converged ? "ok"
                                         : "not_converged"},
          {"initial_rms_px", result.initial_rms_px},
          {"final_rms_px", result.final_rms_px},
          {"iterations", result.iterations},
          {"cost", result.final_cost},
          {"initial_cost", result.initial_cost},
          {"cameras", input->bundle.cameras.size()},
          {"points", result.points},
          {"left_out_points", input->sparse ? input->sparse->left_out : 0},
          {"observations", result.observations},
          {"dropped_observations", result.dropped_observations},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_bundle_command(Lab& lab) {
  const auto options = std::make_shared<BundleOptions>();
  CLI::App& app =
      lab.add("bundle", "bundle adjustment of one window of cameras and points", "window.txt --out adjusted.txt",
              [options](int repeat) { return run_bundle(*options, repeat); });
  app.add_option("WINDOW", options->window,
                 "window file (ncam npts nobs, intrinsics, observations, cameras, points), BAL file, or folder of a "
                 "COLMAP text model")
      ->required();
  app.add_option("--cameras", options->cameras,
                 "FIRST COUNT of the cameras of a BAL file (in its order, from 0) or COLMAP model (in the order of "
                 "names) that are adjusted; default: all")
      ->expected(2);
  app.add_option("--out", options->out,
                 "file or folder for the adjusted cameras and points, in the format of the input")
      ->required();
  app.add_option("--robust", options->params.robust_px, "scale of Cauchy's loss in px; 0: least squares")
      ->check(finite_in(0, 1000));
  app.add_option("--max-iterations", options->params.max_iterations, "most steps, accepted and rejected")
      ->check(CLI::Range(1, 10000));
  app.add_option("--tolerance", options->params.relative_tolerance,
                 "relative gain of a step below which the adjustment ends")
      ->check(finite_in(0, 1));
}

}  // namespace ilp::lab
