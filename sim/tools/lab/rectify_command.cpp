// rectify: resamples two images with poses from a COLMAP model to a rectified pair, or to the panels of a polar
// rectification.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/colmap_reader.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

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

RectifiedImages images_of(const RectifiedPair& pair) {
  const GrayImage blank(pair.width, pair.height);
  return {blank, blank, blank, blank};
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
  std::size_t blind = 0;          ///< points in both images for which no panel gives depth
};

/// The panel that gives depth for a pixel of the left image.
const RectifiedPair* panel_at(const RectificationPlan& plan, const CameraModel& camera, const Vec2& pixel) {
  const Vec2 normalised = normalised_from_pixel(camera, pixel);
  for (std::size_t i = 0; i < plan.count; ++i) {
    if (gives_depth(plan.panels[i].pair, normalised)) return &plan.panels[i].pair;
  }
  return nullptr;
}

VerticalErrors vertical_errors(const ColmapModel& model, const ColmapImage& a, const ColmapImage& b,
                               const RectificationPlan& plan) {
  VerticalErrors errors;
  const auto measure = [&](const Vec2& in_a, const Vec2& in_b, std::vector<double>& out) {
    const RectifiedPair* pair = panel_at(plan, model.camera, in_a);
    if (pair == nullptr) return false;
    const double apart = row_of(*pair, Side::left, model.camera, in_a) - row_of(*pair, Side::right, model.camera, in_b);
    // At the seam of the azimuth the two may be a whole turn apart.
    const double turn = 2 * pi * pair->focal_px;
    out.push_back(std::fabs(pair->method == RectificationMethod::polar ? std::remainder(apart, turn) : apart));
    return true;
  };
  for (const auto& [id, point] : model.points) {
    const std::optional<Vec2> in_a = project(model.camera, a.cam_from_world, point);
    const std::optional<Vec2> in_b = project(model.camera, b.cam_from_world, point);
    if (in_a && in_b && !measure(*in_a, *in_b, errors.projected)) ++errors.blind;
    const auto seen_a = a.seen.find(id), seen_b = b.seen.find(id);
    if (seen_a != a.seen.end() && seen_b != b.seen.end()) {
      measure(seen_a->second, seen_b->second, errors.observed);
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
  host::write_png(folder / "left.png", images.left.view());
  host::write_png(folder / "right.png", images.right.view());
  host::write_png(folder / "left_valid.png", images.left_valid.view());
  host::write_png(folder / "right_valid.png", images.right_valid.view());
}

Json described(const RectifiedPanel& panel) {
  const RectifiedPair& pair = panel.pair;
  return {{"width", pair.width},
          {"height", pair.height},
          {"focal_px", pair.focal_px},
          {"cx_left", pair.cx_left},
          {"cx_right", pair.cx_right},
          {"cy", pair.cy},
          {"baseline", pair.baseline},
          {"min_disparity", panel.range.min_px},
          {"max_disparity", panel.range.max_px}};
}

/// Where the images of a panel lie: the only one directly in the folder.
fs::path folder_of(const RectificationPlan& plan, std::size_t i, const fs::path& out) {
  return plan.count == 1 ? out : out / ("panel-" + std::to_string(i + 1));
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

  const auto plan = std::make_unique<RectificationPlan>();
  DepthRange depth;
  Status status = depth_range_of(left.cam_from_world, points.data(), points.size(), outlier_share, depth_margin, depth);
  if (status.ok()) {
    status = plan_panels(model.camera, left.cam_from_world, right.cam_from_world, depth, RectificationParams{}, *plan);
  }
  Json result = {{"verdict", verdict_of(status, "rectify")}, {"method", Json()}};
  // A cut range is a warning: the pair is good.
  if (!status.ok() && !status.is(StatusCode::disparity_range_exceeded)) {
    if (status.is(StatusCode::rectification_impossible)) result["reason"] = host::describe(status);
    return result;
  }

  std::vector<RectifiedImages> images;
  for (std::size_t i = 0; i < plan->count; ++i) images.push_back(images_of(plan->panels[i].pair));
  const double kernel_ms = time_kernel(
      repeat, [] {},
      [&] {
        for (std::size_t i = 0; i < plan->count; ++i) {
          status = rectify(plan->panels[i].pair, model.camera, a, b, images[i]);
          if (!status.ok()) return;
        }
      });
  host::require(status, "rectify " + options.a + " and " + options.b);
  for (std::size_t i = 0; i < plan->count; ++i) write_pair(folder_of(*plan, i, options.out), images[i]);

  const VerticalErrors errors = vertical_errors(model, left, right, *plan);
  const bool polar = plan->method == RectificationMethod::polar;
  result["method"] = polar ? "polar" : "homography";
  result["resolution"] = plan->resolution;
  result["max_vertical_error_px"] = largest_of(errors.projected);
  result["points"] = errors.projected.size();
  result["max_observed_vertical_error_px"] = largest_of(errors.observed);
  result["median_observed_vertical_error_px"] = median_of(errors.observed);
  result["observed_points"] = errors.observed.size();
  if (polar) {
    result["blind_radius_px"] = plan->blind_radius_px;
    result["blind_points"] = errors.blind;
  }
  if (plan->count == 1) {
    result.update(described(plan->panels[0]));
  } else {
    result["panels"] = Json::array();
    for (std::size_t i = 0; i < plan->count; ++i) {
      Json panel = described(plan->panels[i]);
      panel["folder"] = folder_of(*plan, i, options.out).filename().string();
      result["panels"].push_back(panel);
    }
  }
  result["kernel_ms"] = kernel_ms;
  return result;
}

}  // namespace

void add_rectify_command(Lab& lab) {
  const auto options = std::make_shared<RectifyOptions>();
  CLI::App& app = lab.add("rectify", "two images of a COLMAP model, resampled so that matching points share a row",
                          "0001.png 0002.png --model model --out pair",
                          [options](int repeat) { return run_rectify(*options, repeat); });
  app.add_option("A", options->a, "left image, found in the model by its file name")->required();
  app.add_option("B", options->b, "right image")->required();
  app.add_option("--model", options->model, "folder with cameras.txt, images.txt, points3D.txt")->required();
  app.add_option(
         "--out", options->out,
         "folder for left.png, right.png, left_valid.png, right_valid.png; for a polar pair in panel-1, panel-2, ...")
      ->required();
}

}  // namespace ilp::lab
