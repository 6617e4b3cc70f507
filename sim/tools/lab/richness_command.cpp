// richness: computes the Image Richness Index of an image and its cues.

#include <cmath>
#include <memory>

#include "fsw/vision/terrain/richness.hpp"
#include "sim/host/camera_file.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct RichnessOptions {
  std::string image, depth, mask, camera;
};

CameraModel camera_for(const RichnessOptions& options, const GrayImage& image) {
  // What is commonly assumed of a camera that nothing is known of.
  constexpr double focal_per_side = 1.2;
  if (options.camera.empty()) {
    return centred_camera(image.width, image.height, focal_per_side * std::max(image.width, image.height));
  }
  const CameraModel camera = host::read_global_shutter_camera(options.camera);
  require_same_size(image, options.image, camera.width, camera.height, options.camera);
  return camera;
}

struct DepthMap {
  host::Raster<float> inverse, sigma;
};

DepthMap read_depth(const RichnessOptions& options, const GrayImage& image) {
  DepthMap map{host::Raster<float>(image.width, image.height), host::Raster<float>(image.width, image.height)};
  if (options.depth.empty()) return map;
  const host::Raster<float> depth = host::read_pfm(options.depth);
  if (depth.width != image.width || depth.height != image.height) {
    throw std::runtime_error(options.depth + " does not have the size of " + options.image);
  }
  for (std::size_t i = 0; i < depth.samples.size(); ++i) {
    const float inverse = 1 / depth.samples[i];
    if (!(depth.samples[i] > 0) || !(inverse > 0) || !std::isfinite(inverse)) continue;
    map.inverse.samples[i] = inverse;
    // Only marks the pixel as valid: the cues do not weigh.
    map.sigma.samples[i] = inverse;
  }
  return map;
}

Json cues_json(const RichnessCues& cues) {
  return {{"gradient_fine", cues.gradient_fine},
          {"gradient_coarse", cues.gradient_coarse},
          {"entropy", cues.entropy},
          {"contrast", cues.contrast},
          {"relief", cues.relief},
          {"slope_steep", cues.slope_steep},
          {"slope_excess", cues.slope_excess},
          {"roughness_fine", cues.roughness_fine},
          {"roughness_coarse", cues.roughness_coarse},
          {"curvature", cues.curvature},
          {"novelty", cues.novelty},
          {"mask_fraction", cues.mask_fraction},
          {"has_terrain", cues.has_terrain}};
}

Json run_richness(const RichnessOptions& options, int repeat) {
  const GrayImage image = read_camera_image(options.image);
  GrayImage mask = read_mask(options.mask, image, options.image);
  if (mask.samples.empty()) mask = GrayImage(image.width, image.height, 255);
  const CameraModel camera = camera_for(options, image);
  const DepthMap depth = read_depth(options, image);
  const auto workspace = std::make_unique<RichnessWorkspace>();
  const RichnessParams params;
  RichnessCues cues;
  double index = 0;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [] {},
      [&] {
        status = score_richness(camera, image.view(), depth.inverse.view(), depth.sigma.view(), mask.view(), params,
                                RichnessHistory{}, *workspace, cues, index);
      });
  host::require(status, "richness of " + options.image);
  Json result = {{"verdict", "ok"}, {"index", index}};
  result.update(cues_json(cues));
  if (!options.depth.empty()) result["camera"] = options.camera.empty() ? "assumed: focal length 1.2 sides" : "given";
  result["kernel_ms"] = kernel_ms;
  return result;
}

}  // namespace

void add_richness_command(Lab& lab) {
  const auto options = std::make_shared<RichnessOptions>();
  CLI::App& app =
      lab.add("richness", "image richness index and its cues, as for the first image of a flight",
              "0001.png --camera cameras.txt", [options](int repeat) { return run_richness(*options, repeat); });
  app.add_option("IMAGE", options->image, "PNG, PGM, JPEG or TIFF")->required();
  app.add_option("--depth", options->depth,
                 "PFM of the depth along the optical axis; where it is not positive and finite there is no depth");
  app.add_option("--mask", options->mask,
                 "image whose pixels other than 0 are the newly seen part (default: all pixels)");
  app.add_option("--camera", options->camera, "cameras.txt for the terrain cues; without it a focal length is assumed");
}

}  // namespace ilp::lab
