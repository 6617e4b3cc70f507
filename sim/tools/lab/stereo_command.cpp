// stereo: computes the disparities of a rectified pair.

#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
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

struct Pair {
  GrayView left, right;
  MaskView valid;
  StereoParams params;
};

Status match(StereoMatcher& matcher, const Pair& pair, const DisparityRange& range, StereoWorkspace& workspace,
             const DisparityView& result) {
  ILP_TRY(matcher.begin(pair.left, pair.right, pair.valid, pair.valid, range, pair.params, workspace, result));
  return do_all([&] { return matcher.step(pair.left.height); });
}

void check_range(const DisparityRange& range) {
  if (range.max_px < range.min_px) throw UsageError("--max-disparity is below --min-disparity");
  if (range.count() > limits::max_disparities) {
    throw std::runtime_error(std::to_string(range.count()) + " disparities, the limit of the flight software is " +
                             std::to_string(limits::max_disparities) + " (limits::max_disparities of the profile " +
                             limits::profile + ")");
  }
}

/// Of the pixels. Over textured pairs the right range finds 0.85 and more, a range without the true disparities at most
/// 0.15: matches that the noise has made.
constexpr double least_known = 0.25;

/// Of the pixels: those whose disparity lies outside the range, and so were not found or are chance. Over textured
/// pairs a range that holds the true disparities leaves at most 0.003 outside, one that cuts off a fifth of them 0.10
/// and more.
constexpr double most_outside = 0.05;

struct Outside {
  DisparityRange searched;
  double below = 0, above = 0;  ///< shares of the pixels
};

/// What a search finds that goes as far again to both sides. Nothing where the flight software has no more disparities.
std::optional<Outside> outside(const Pair& pair, const DisparityRange& range, StereoWorkspace& workspace) {
  const std::int32_t more = std::min(range.count(), (limits::max_disparities - range.count()) / 2);
  if (more < 2) return std::nullopt;
  Outside found{{range.min_px - more, range.max_px + more}};
  host::Raster<float> disparity(pair.left.width, pair.left.height), sigma(pair.left.width, pair.left.height);
  StereoMatcher matcher;
  host::require(match(matcher, pair, found.searched, workspace, {disparity.view(), sigma.view()}), "wider stereo");
  std::size_t below = 0, above = 0;
  for (std::size_t i = 0; i < sigma.samples.size(); ++i) {
    if (sigma.samples[i] == 0) continue;
    below += disparity.samples[i] < static_cast<float>(range.min_px - 1) ? 1U : 0U;
    above += disparity.samples[i] > static_cast<float>(range.max_px + 1) ? 1U : 0U;
  }
  const double pixels = static_cast<double>(sigma.samples.size());
  found.below = static_cast<double>(below) / pixels;
  found.above = static_cast<double>(above) / pixels;
  return found;
}

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
  const Pair pair{left.view(), right.view(), everywhere.view(), params};
  StereoMatcher matcher;
  Status status;
  const double kernel_ms = time_kernel(
      repeat, [] {},
      [&] {
        status = match(matcher, pair, options.range, *workspace, {disparity.view(), sigma.view()});
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
  const std::optional<Outside> missed = outside(pair, options.range, *workspace);
  const bool cut = missed && missed->below + missed->above > most_outside;
  if (cut) {
    std::cerr << "ilp-lab stereo: a search from " << missed->searched.min_px << " to " << missed->searched.max_px
              << " px finds " << host::fixed(100 * missed->below, 1) << " % of the pixels below "
              << options.range.min_px << " px and " << host::fixed(100 * missed->above, 1) << " % above "
              << options.range.max_px << " px: widen the range\n";
  }
  return {{"verdict", few   ? name_of(DepthVerdict::too_few_valid)
                      : cut ? "range_too_small"
                            : name_of(DepthVerdict::ok)},
          {"below", missed ? Json(missed->below) : Json()},
          {"above", missed ? Json(missed->above) : Json()},
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
