// stereo: a rectified pair to disparities.

#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "fsw/records/words.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct StereoOptions {
  std::string left, right, out, sigma;
  DisparityRange range;
  std::string matcher = name_of(StereoParams{}.matcher);
};

Status match(StereoMatcher& matcher, GrayView left, GrayView right, MaskView valid, const DisparityRange& range,
             const StereoParams& params, StereoWorkspace& workspace, const DisparityView& result) {
  ILP_TRY(matcher.begin(left, right, valid, valid, range, params, workspace, result));
  return do_all([&] { return matcher.step(left.height); });
}

void check_range(const DisparityRange& range) {
  if (range.max_px < range.min_px) throw UsageError("--max-disparity is below --min-disparity");
  if (range.count() > limits::max_disparities) {
    throw std::runtime_error(std::to_string(range.count()) + " disparities, the limit of the flight software is " +
                             std::to_string(limits::max_disparities) + " (limits::max_disparities in cfg/limits.hpp)");
  }
}

/// Of the pixels. Over textured pairs the right range finds 0.85 and more, a range without the true disparities at most
/// 0.15: matches that the noise has made.
constexpr double least_known = 0.25;

Json run_stereo(const StereoOptions& options, int repeat) {
  check_range(options.range);
  const GrayImage left = read_rectified_image(options.left);
  const GrayImage right = read_rectified_image(options.right);
  require_same_size(right, options.right, left.width, left.height, options.left);
  const GrayImage everywhere(left.width, left.height, 255);
  host::Raster<float> disparity(left.width, left.height), sigma(left.width, left.height);
  const auto workspace = std::make_unique<StereoWorkspace>();
  StereoParams params;
  const EnumValue* const choice = find_value(StereoMatcherChoice_values, options.matcher.c_str());
  params.matcher = static_cast<StereoMatcherChoice>(choice->number);
  StereoMatcher matcher;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [] {},
      [&] {
        status = match(matcher, left.view(), right.view(), everywhere.view(), options.range, params, *workspace,
                       {disparity.view(), sigma.view()});
      });
  host::require(status, "stereo of " + options.left + " and " + options.right);
  std::size_t valid = 0, supported = 0;
  for (std::size_t i = 0; i < sigma.samples.size(); ++i) {
    if (sigma.samples[i] == 0) {
      disparity.samples[i] = sigma.samples[i] = std::numeric_limits<float>::infinity();
      continue;
    }
    ++valid;
    supported += matcher.result().kind.data[i] == DisparityKind::supported ? 1U : 0U;
  }
  host::write_pfm(options.out, disparity.view());
  if (!options.sigma.empty()) host::write_pfm(options.sigma, sigma.view());
  const double pixels = static_cast<double>(left.samples.size());
  const double known = static_cast<double>(valid) / pixels;
  const bool few = known < least_known;
  if (few) {
    std::cerr << "ilp-lab stereo: only " << host::fixed(100 * known, 1) << " % of the pixels have a disparity between "
              << options.range.min_px << " and " << options.range.max_px
              << " px, and those may be chance: the range is wrong (x_left - x_right is positive for near ground), the "
                 "pair is not rectified, or it has no texture\n";
  }
  return {{"verdict", few ? name_of(DepthVerdict::too_few_valid) : name_of(DepthVerdict::ok)},
          {"width", left.width},
          {"height", left.height},
          {"disparities", options.range.count()},
          {"valid", known},
          {"valid_pixels", valid},
          {"supported_pixels", supported},
          {"mega_disparities_per_s", pixels * options.range.count() / (kernel_ms * 1000)},
          {"kernel_ms", kernel_ms}};
}

}  // namespace

void add_stereo_command(Lab& lab) {
  const auto options = std::make_shared<StereoOptions>();
  CLI::App& app = lab.add("stereo", "disparities x_left - x_right of a rectified pair, at the pixels of the left image",
                          "left.png right.png --min-disparity 0 --max-disparity 64 --out disparities.pfm",
                          [options](int repeat) { return run_stereo(*options, repeat); });
  app.add_option("LEFT", options->left, "left image: PNG, PGM, JPEG or TIFF")->required();
  app.add_option("RIGHT", options->right, "right image")->required();
  app.add_option("--min-disparity", options->range.min_px, "smallest disparity that is searched, px")
      ->required()
      ->check(CLI::Range(-32768, 32767));
  app.add_option("--max-disparity", options->range.max_px, "largest disparity that is searched, px")
      ->required()
      ->check(CLI::Range(-32768, 32767));
  app.add_option("--out", options->out, "PFM file for the disparities, +infinity where there is none")->required();
  app.add_option("--sigma", options->sigma, "PFM file for their one-sigma errors in px, +infinity where there is none");
  std::vector<std::string> matchers;
  for (const EnumValue& value : StereoMatcherChoice_values) matchers.emplace_back(value.name);
  app.add_option("--matcher", options->matcher, "how the disparities of a scanline are chosen")
      ->check(CLI::IsMember(matchers));
}

}  // namespace ilp::lab
