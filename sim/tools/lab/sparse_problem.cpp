#include "sim/tools/lab/sparse_problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/colmap.hpp"
#include "sim/tools/lab/input_files.hpp"

namespace ilp::lab {
namespace fs = std::filesystem;
namespace {

constexpr double largest_count = 1e9;
constexpr std::uint32_t not_chosen = 0xFFFFFFFFU;

/// A camera of BAL looks along -z with y up.
const Vec3 bal_axes(1, -1, -1);

struct BalSizes {
  std::uint32_t cameras = 0, points = 0, observations = 0;
};

BalSizes read_bal_sizes(NumberFile& file) {
  std::vector<double> n;
  file.expect(3, "cameras points observations", n);
  return {file.whole(n[0], "cameras", largest_count), file.whole(n[1], "points", largest_count),
          file.whole(n[2], "observations", largest_count)};
}

/// The numbers of the rest of a file, on lines of any length.
class NumberStream {
 public:
  explicit NumberStream(NumberFile& file) : file_(file) {}
  double next(const char* what) {
    while (at_ == line_.size()) {
      at_ = 0;
      if (!file_.next(line_)) file_.fail(std::string("the file ends before ") + what);
    }
    return line_[at_++];
  }
  Vec3 vector(const char* what) {
    const double x = next(what), y = next(what);
    return {x, y, next(what)};
  }
  [[nodiscard]] bool at_end() { return at_ == line_.size() && !file_.next(line_); }

 private:
  NumberFile& file_;
  std::vector<double> line_;
  std::size_t at_ = 0;
};

SparseCamera read_bal_camera(NumberFile& file, NumberStream& numbers) {
  constexpr const char* what = "the nine numbers of every camera";
  constexpr double largest_angle = 1e4;
  const Vec3 turn = numbers.vector(what);
  if (!(turn.norm() < largest_angle)) file.fail("the rotation is no angle-axis vector in rad");
  const Vec3 shift = numbers.vector(what);
  SparseCamera camera;
  for (double& value : camera.intrinsics) value = numbers.next(what);
  const double focal = camera.intrinsics[0];
  if (!(focal > 0)) file.fail("the focal length " + exact_text(focal) + " is not positive");
  const Mat3 flip = bal_axes.asDiagonal();
  camera.adjusted.pose = pose_from({flip * rotation_from_vector(turn), flip * shift});
  camera.adjusted.fx = camera.adjusted.fy = focal;
  return camera;
}

/// The radius r with r (1 + k1 r^2 + k2 r^4) = distorted, by Newton's method; none where the lens folds over before.
std::optional<double> undistorted_radius(double distorted, double k1, double k2) {
  double r = distorted;
  for (int i = 0; i < 50; ++i) {
    const double r2 = r * r, slope = 1 + r2 * (3 * k1 + r2 * 5 * k2);
    if (!(slope > 0)) return std::nullopt;
    const double step = (r * (1 + r2 * (k1 + r2 * k2)) - distorted) / slope;
    r -= step;
    if (std::fabs(step) <= 1e-14 * std::max(1.0, r)) return r;
  }
  return std::nullopt;
}

void undistort_bal(const fs::path& path, SparseProblem& problem) {
  for (SparseObservation& o : problem.observations) {
    const auto& [focal, k1, k2] = problem.cameras[o.camera].intrinsics;
    const double distorted = std::sqrt(o.x * o.x + o.y * o.y) / focal;
    const auto radius = distorted > 0 ? undistorted_radius(distorted, k1, k2) : 0.0;
    if (!radius) {
      throw std::runtime_error("BAL file " + path.string() + ": the lens of camera " + std::to_string(o.camera) +
                               " has no ray for its observation " + exact_text(o.x) + " " + exact_text(o.y));
    }
    const double stretch = distorted > 0 ? *radius / distorted : 1;
    o.ideal_x = stretch * o.x;
    o.ideal_y = -stretch * o.y;
  }
}

std::vector<std::uint32_t> chosen_points(const SparseProblem& problem, const CameraRange& cameras,
                                         std::size_t& left_out) {
  std::vector<std::size_t> views(problem.points.size());
  for (const SparseObservation& o : problem.observations) {
    if (o.camera >= cameras.first && o.camera - cameras.first < cameras.count) ++views[o.point];
  }
  std::vector<std::uint32_t> order(problem.points.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return views[a] > views[b]; });
  std::vector<std::uint32_t> chosen;
  std::size_t observations = 0;
  left_out = 0;
  for (const std::uint32_t point : order) {
    if (views[point] < 2) break;
    if (chosen.size() == limits::max_bundle_points || observations + views[point] > limits::max_bundle_observations) {
      ++left_out;
      continue;
    }
    observations += views[point];
    chosen.push_back(point);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::string bal_text(const SparseProblem& problem) {
  std::string text = std::to_string(problem.cameras.size()) + " " + std::to_string(problem.points.size()) + " " +
                     std::to_string(problem.observations.size()) + "\n";
  for (const SparseObservation& o : problem.observations) {
    text +=
        std::to_string(o.camera) + " " + std::to_string(o.point) + " " + exact_text(o.x) + " " + exact_text(o.y) + "\n";
  }
  const auto lines = [&](const auto& values) {
    for (const double value : values) text += exact_text(value) + "\n";
  };
  for (const SparseCamera& camera : problem.cameras) {
    const RigidTransform pose = cam_from_world(camera.adjusted.pose);
    const Mat3 flip = bal_axes.asDiagonal();
    lines(vector_from_rotation(flip * pose.rotation));
    lines(Vec3(flip * pose.translation));
    lines(camera.intrinsics);
  }
  for (const Vec3& point : problem.points) lines(point);
  return text;
}

/// Mean distance of a point's projections from where it was seen, as COLMAP states it.
double error_px(const SparseProblem& problem, const SparseObservation& o) {
  const BundleCamera& camera = problem.cameras[o.camera].adjusted;
  const Vec3 seen = cam_from_world(camera.pose) * problem.points[o.point];
  const double x = camera.fx * seen.x() / seen.z() + camera.cx - o.ideal_x;
  const double y = camera.fy * seen.y() / seen.z() + camera.cy - o.ideal_y;
  return std::sqrt(x * x + y * y);
}

void write_colmap(const SparseProblem& problem, const fs::path& folder) {
  host::ColmapText text;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    const RigidTransform pose = cam_from_world(problem.cameras[i].adjusted.pose);
    host::ColmapView view;
    view.id = static_cast<std::int64_t>(i) + 1;
    quaternion_from_rotation(pose.rotation, view.q_cam_from_world.data());
    view.translation = pose.translation;
    view.name = problem.cameras[i].name;
    text.views.push_back(std::move(view));
  }
  for (const Vec3& point : problem.points) text.points.emplace_back().position = point;
  for (const SparseObservation& o : problem.observations) {
    std::vector<host::ColmapObservation>& seen = text.views[o.camera].seen;
    host::ColmapPoint& point = text.points[o.point];
    point.track.emplace_back(text.views[o.camera].id, seen.size());
    point.error_px += error_px(problem, o);
    seen.push_back({o.x, o.y, o.point});
  }
  for (host::ColmapPoint& point : text.points) point.error_px /= static_cast<double>(point.track.size());
  fs::create_directories(folder);
  host::write_colmap_camera(folder / "cameras.txt", *problem.colmap);
  host::write_colmap_text(text, folder);
}

}  // namespace

bool is_bal(const fs::path& path) {
  NumberFile file("problem file", path);
  std::vector<double> n;
  if (!file.next(n) || n.size() != 3) return false;
  const double observations = n[2];
  double lines = 0;
  while (lines <= observations && file.next(n)) {
    if (n.size() != 4) return lines == observations;
    ++lines;
  }
  return false;
}

SparseProblem read_bal(const fs::path& path) {
  NumberFile file("BAL file", path);
  const BalSizes sizes = read_bal_sizes(file);
  SparseProblem problem;
  std::vector<double> n;
  for (std::uint32_t i = 0; i < sizes.observations; ++i) {
    file.expect(4, "camera point x y", n);
    problem.observations.push_back(
        {file.whole(n[0], "camera", sizes.cameras), file.whole(n[1], "point", sizes.points), n[2], n[3]});
  }
  NumberStream numbers(file);
  for (std::uint32_t i = 0; i < sizes.cameras; ++i) problem.cameras.push_back(read_bal_camera(file, numbers));
  for (std::uint32_t i = 0; i < sizes.points; ++i) problem.points.push_back(numbers.vector("the place of every point"));
  if (!numbers.at_end()) file.fail("the problem ended before this line");
  undistort_bal(path, problem);
  return problem;
}

SparseProblem read_colmap_problem(const fs::path& folder) {
  ColmapModel model = read_colmap_model(folder);
  std::stable_sort(model.images.begin(), model.images.end(),
                   [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  SparseProblem problem;
  problem.colmap = model.camera;
  std::map<std::int64_t, std::uint32_t> index_of;
  for (const auto& [id, place] : model.points) {
    index_of[id] = static_cast<std::uint32_t>(problem.points.size());
    problem.points.push_back(place);
  }
  for (const ColmapImage& image : model.images) {
    SparseCamera camera;
    camera.adjusted = {pose_from(image.cam_from_world), model.camera.fx, model.camera.fy, model.camera.cx,
                       model.camera.cy};
    camera.name = image.name;
    for (const auto& [id, pixel] : image.seen) {
      const auto point = index_of.find(id);
      if (point == index_of.end())
        throw std::runtime_error((folder / "points3D.txt").string() + " has no point " + std::to_string(id) +
                                 ", which image " + image.name + " sees");
      const Vec2 ideal = ideal_from_pixel(model.camera, pixel);
      if (!ideal.allFinite())
        throw std::runtime_error((folder / "images.txt").string() + ": the lens has no ray for the pixel " +
                                 exact_text(pixel.x()) + " " + exact_text(pixel.y()) + " of image " + image.name);
      problem.observations.push_back({static_cast<std::uint32_t>(problem.cameras.size()), point->second, pixel.x(),
                                      pixel.y(), ideal.x(), ideal.y()});
    }
    problem.cameras.push_back(std::move(camera));
  }
  return problem;
}

SparseWindow choose_window(const SparseProblem& problem, const CameraRange& wanted) {
  const auto all = static_cast<std::uint32_t>(problem.cameras.size());
  if (all == 0) throw std::runtime_error("the problem has no camera");
  CameraRange cameras = wanted;
  if (cameras.count == 0) cameras = {0, all};
  if (cameras.first >= all || cameras.count > all - cameras.first)
    throw std::runtime_error("--cameras goes beyond the problem, which has cameras 0 to " + std::to_string(all - 1));
  if (cameras.count > limits::max_bundle_cameras)
    throw std::runtime_error(std::to_string(cameras.count) + " cameras, the limit of the flight software is " +
                             std::to_string(limits::max_bundle_cameras) +
                             " (limits::max_bundle_cameras in cfg/limits.hpp): choose some with --cameras FIRST COUNT");
  SparseWindow window;
  window.problem.colmap = problem.colmap;
  window.problem.cameras.assign(problem.cameras.begin() + cameras.first,
                                problem.cameras.begin() + cameras.first + cameras.count);
  const std::vector<std::uint32_t> chosen = chosen_points(problem, cameras, window.left_out);
  if (chosen.empty()) throw std::runtime_error("no point is seen by two of the cameras");
  std::vector<std::uint32_t> index_of(problem.points.size(), not_chosen);
  for (const std::uint32_t point : chosen) {
    index_of[point] = static_cast<std::uint32_t>(window.problem.points.size());
    window.problem.points.push_back(problem.points[point]);
  }
  for (SparseObservation o : problem.observations) {
    if (o.camera < cameras.first || o.camera - cameras.first >= cameras.count || index_of[o.point] == not_chosen)
      continue;
    o.camera -= cameras.first;
    o.point = index_of[o.point];
    window.problem.observations.push_back(o);
  }
  return window;
}

void make_bundle(const SparseProblem& window, BundleProblem& bundle) {
  bundle = {};
  for (const SparseCamera& camera : window.cameras) (void)bundle.cameras.push_back(camera.adjusted);
  for (const Vec3& point : window.points) (void)bundle.points.push_back({{point.x(), point.y(), point.z()}});
  for (const SparseObservation& o : window.observations) {
    (void)bundle.observations.push_back(
        {static_cast<std::uint16_t>(o.camera), static_cast<std::uint16_t>(o.point), o.ideal_x, o.ideal_y});
  }
  bundle.cameras[0].fixed = true;
  const Vec3 first = camera_centre(cam_from_world(bundle.cameras[0].pose));
  for (std::size_t i = 1; i < bundle.cameras.size() && !bundle.hold.held; ++i) {
    const bool apart = (camera_centre(cam_from_world(bundle.cameras[i].pose)) - first).norm() > 0;
    bundle.hold = {apart, 0, static_cast<std::uint16_t>(i)};
  }
}

void take_bundle(const BundleProblem& bundle, SparseProblem& window) {
  for (std::size_t i = 0; i < window.cameras.size(); ++i) window.cameras[i].adjusted.pose = bundle.cameras[i].pose;
  for (std::size_t i = 0; i < window.points.size(); ++i) {
    const double(&p)[3] = bundle.points[i].position;
    window.points[i] = Vec3(p[0], p[1], p[2]);
  }
}

void write_problem(const SparseProblem& problem, const fs::path& place) {
  if (problem.colmap) {
    write_colmap(problem, place);
  } else {
    write_text(place, bal_text(problem));
  }
}

}  // namespace ilp::lab
