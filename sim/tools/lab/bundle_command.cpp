// bundle: one window of bundle adjustment.

#include <memory>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/bundle_window.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct BundleOptions {
  std::string window, out;
  BundleParams params;
};

Json run_bundle(const BundleOptions& options, int repeat) {
  const auto window = std::make_unique<BundleProblem>();
  const auto problem = std::make_unique<BundleProblem>();
  const auto adjuster = std::make_unique<BundleAdjuster>();
  read_window(options.window, *window);
  BundleResult result;
  Status status;
  const double kernel_ms = time_kernel(
      repeat,
      [&] {
        *problem = *window;
        result = {};
      },
      [&] { status = adjuster->run(*problem, options.params, result); });
  const std::string failure = verdict_of(status, "bundle");
  if (status.ok()) write_window(options.out, *problem);
  return {{"verdict", !status.ok()       ? failure
                      : result.converged ? "ok"
                                         : "not_converged"},
          {"initial_rms_px", result.initial_rms_px},
          {"final_rms_px", result.final_rms_px},
          {"iterations", result.iterations},
          {"cost", result.final_cost},
          {"initial_cost", result.initial_cost},
          {"points", result.points},
          {"observations", result.observations},
          {"dropped_observations", result.dropped_observations},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_bundle_command(Lab& lab) {
  const auto options = std::make_shared<BundleOptions>();
  CLI::App& app = lab.add("bundle", "bundle adjustment of one window of cameras and points",
                          [options](int repeat) { return run_bundle(*options, repeat); });
  app.add_option("WINDOW", options->window, "window file: ncam npts nobs, intrinsics, observations, cameras, points")
      ->required();
  app.add_option("--out", options->out, "file for the adjusted window, in the same form")->required();
  app.add_option("--robust", options->params.robust_px, "Huber bound in px; 0: least squares")
      ->check(finite_in(0, 1000));
  app.add_option("--max-iterations", options->params.max_iterations, "most steps, accepted and rejected")
      ->check(CLI::Range(1, 10000));
  app.add_option("--tolerance", options->params.relative_tolerance,
                 "relative gain of a step below which the adjustment ends")
      ->check(finite_in(0, 1));
}

}  // namespace ilp::lab
