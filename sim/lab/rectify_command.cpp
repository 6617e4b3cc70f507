// rectify: two images with the poses of a COLMAP model to a rectified pair.

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/rectification.hpp"
#include "fsw/vision/stereo/resample.hpp"
#include "sim/io/status_error.hpp"
#include "sim/lab/colmap_reader.hpp"
#include "sim/lab/image_input.hpp"
#include "sim/lab/lab.hpp"

namespace ilp::lab {
namespace fs = std::filesystem;
namespace {

struct RectifyOptions {
  std::string a, b, model, out;
};

struct RectifiedImages {
  GrayImage left, right, left_valid, right_valid;
};

// As onboard: points far off on either side are mistakes, and ground between the points may be nearer or farther.
constexpr double outlier_share = 0.01;
constexpr double depth_margin = 0.1;

/// Points that A sees; all points where the model does not say.
std::vector<Vec3> points_of(const ColmapModel& model, const ColmapImage& image) {
  std::vector<Vec3> points;
  for (const auto& [id, position] : model.points) {
    if (image.seen.empty() || image.seen.contains(id)) points.push_back(position);
  }
  return points;
}

Status resample(const RectifiedPair& pair, Side side, const CameraModel& camera, const GrayImage& source,
                GrayImage& rectified, GrayImage& valid) {
  return resample_rows(pair, side, camera, source.view(), 0, pair.height, rectified.view(), valid.view());
}

Status rectify(const RectifiedPair& pair, const CameraModel& camera, const GrayImage& a, const GrayImage& b,
               RectifiedImages& out) {
  ILP_TRY(resample(pair, Side::left, camera, a, out.left, out.left_valid));
  return resample(pair, Side::right, camera, b, out.right, out.right_valid);
}

/// Where a pixel of the real image lies in the rectified one.
double row_of(const RectifiedPair& pair, Side side, const CameraModel& camera, const Vec2& pixel) {
  const Vec2 normalised = normalised_from_pixel(camera, pixel);
  return (side == Side::left ? rectified_left(pair, normalised) : rectified_right(pair, normalised)).y();
}

std::optional<Vec2> project(const CameraModel& camera, const RigidTransform& cam_from_world, const Vec3& point) {
  const Vec3 x = cam_from_world * point;
  if (!(x.z() > 0)) return {};
  const FieldOfView view = field_of_view(camera);
  const Vec2 normalised(x.x() / x.z(), x.y() / x.z());
  const bool seen = normalised.x() >= view.min_x && normalised.x() <= view.max_x && normalised.y() >= view.min_y &&
                    normalised.y() <= view.max_y;
  if (!seen) return {};
  return pixel_from_normalised(camera, normalised);
}

/// Vertical distances in the rectified pair, px.
struct VerticalErrors {
  std::vector<double> projected;  ///< of the model's points, projected into both images
  std::vector<double> observed;   ///< of the model's observations, with the errors of their corners
};

VerticalErrors vertical_errors(const ColmapModel& model, const ColmapImage& a, const ColmapImage& b,
                               const RectifiedPair& pair) {
  VerticalErrors errors;
  const auto error = [&](const Vec2& in_a, const Vec2& in_b) {
    return std::fabs(row_of(pair, Side::left, model.camera, in_a) - row_of(pair, Side::right, model.camera, in_b));
  };
  for (const auto& [id, point] : model.points) {
    const std::optional<Vec2> in_a = project(model.camera, a.cam_from_world, point);
    const std::optional<Vec2> in_b = project(model.camera, b.cam_from_world, point);
    if (in_a && in_b) errors.projected.push_back(error(*in_a, *in_b));
    const auto seen_a = a.seen.find(id), seen_b = b.seen.find(id);
    if (seen_a != a.seen.end() && seen_b != b.seen.end()) {
      errors.observed.push_back(error(seen_a->second, seen_b->second));
    }
  }
  return errors;
}

Json largest_of(const std::vector<double>& errors) {
  return errors.empty() ? Json() : Json(*std::max_element(errors.begin(), errors.end()));
}
Json median_of(const std::vector<double>& errors) {
  return errors.empty() ? Json() : Json(median(errors));
}

void write_pair(const fs::path& folder, const RectifiedImages& images) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error("cannot create " + folder.string() + ": " + error.message());
  sim::write_png(folder / "left.png", images.left.view());
  sim::write_png(folder / "right.png", images.right.view());
  sim::write_png(folder / "left_valid.png", images.left_valid.view());
  sim::write_png(folder / "right_valid.png", images.right_valid.view());
}

Json run_rectify(const RectifyOptions& options, int repeat) {
  const GrayImage a = read_camera_image(options.a), b = read_camera_image(options.b);
  const ColmapModel model = read_colmap_model(options.model);
  const std::string cameras = (fs::path(options.model) / "cameras.txt").string();
  require_same_size(a, options.a, model.camera.width, model.camera.height, cameras);
  require_same_size(b, options.b, model.camera.width, model.camera.height, cameras);
  const ColmapImage& left = find_image(model, options.a);
  const ColmapImage& right = find_image(model, options.b);
  const std::vector<Vec3> points = points_of(model, left);

  RectifiedPair pair;
  DisparityRange range;
  DepthRange depth;
  Status status = depth_range_of(left.cam_from_world, points.data(), points.size(), outlier_share, depth_margin, depth);
  if (status.ok()) {
    status = plan_rectification(model.camera, left.cam_from_world, right.cam_from_world, depth, RectificationParams{},
                                pair, range);
  }
  Json result = {{"verdict", verdict_of(status, "rectify")}, {"method", Json()}};
  // A cut range is a warning: the pair is good.
  if (!status.ok() && !status.is(StatusCode::disparity_range_exceeded)) {
    if (status.is(StatusCode::rectification_impossible)) result["reason"] = sim::describe(status);
    return result;
  }

  RectifiedImages images;
  for (GrayImage* image : {&images.left, &images.right, &images.left_valid, &images.right_valid}) {
    *image = GrayImage(pair.width, pair.height);
  }
  const double kernel_ms = time_kernel(
      repeat, [] {}, [&] { status = rectify(pair, model.camera, a, b, images); });
  sim::require(status, "rectify");
  write_pair(options.out, images);

  const VerticalErrors errors = vertical_errors(model, left, right, pair);
  result["method"] = "homography";
  result["max_vertical_error_px"] = largest_of(errors.projected);
  result["points"] = errors.projected.size();
  result["max_observed_vertical_error_px"] = largest_of(errors.observed);
  result["median_observed_vertical_error_px"] = median_of(errors.observed);
  result["observed_points"] = errors.observed.size();
  result["width"] = pair.width;
  result["height"] = pair.height;
  result["focal_px"] = pair.focal_px;
  result["cx_left"] = pair.cx_left;
  result["cx_right"] = pair.cx_right;
  result["cy"] = pair.cy;
  result["baseline"] = pair.baseline;
  result["min_disparity"] = range.min_px;
  result["max_disparity"] = range.max_px;
  result["kernel_ms"] = kernel_ms;
  return result;
}

}  // namespace

void add_rectify_command(Lab& lab) {
  const auto options = std::make_shared<RectifyOptions>();
  CLI::App& app = lab.add("rectify", "two images of a COLMAP model turned so that matching points share a row",
                          [options](int repeat) { return run_rectify(*options, repeat); });
  app.add_option("A", options->a, "left image, found in the model by its file name")->required();
  app.add_option("B", options->b, "right image")->required();
  app.add_option("--model", options->model, "folder with cameras.txt, images.txt, points3D.txt")->required();
  app.add_option("--out", options->out, "folder for left.png, right.png, left_valid.png, right_valid.png")->required();
}

}  // namespace ilp::lab
