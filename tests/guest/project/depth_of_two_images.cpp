// depth_of_two_images A.pgm B.pgm OUT.pfm: depth at each pixel of A, in units of the distance between the cameras.
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "relative_pose.hpp"

using namespace ilp;

int main(int count, char** names) {
  if (count != 4) return 2;
  auto a = read_pgm(names[1]), b = read_pgm(names[2]);
  const RelativePose pose = relative_pose(a.view(), b.view());
  DepthRange range;
  check(depth_range_of({}, pose.points.data(), pose.points.size(), 0.01, 0.1, range), "range of depths");
  const auto plan = std::make_unique<RectificationPlan>();
  check(plan_panels(camera, {}, pose.b_from_a, range, {}, *plan), "rectification");

  Picture<float> inverse(a.width, a.height), sigma = inverse;
  std::vector<std::uint64_t> supported(static_cast<std::size_t>(supported_words(a.width) * a.height));
  const DepthView depth{inverse.view(), sigma.view(), {supported.data(), supported_words(a.width), a.height}};
  const auto workspace = std::make_unique<StereoWorkspace>();
  for (std::size_t i = 0; i < plan->count; ++i) {
    const auto& [pair, disparities] = plan->panels[i];
    Picture<std::uint8_t> left(pair.width, pair.height), left_mask = left, right = left, right_mask = left;
    check(resample_rows(pair, Side::left, camera, a.view(), 0, pair.height, left.view(), left_mask.view()), "left");
    check(resample_rows(pair, Side::right, camera, b.view(), 0, pair.height, right.view(), right_mask.view()), "right");
    Picture<float> disparity(pair.width, pair.height), error = disparity;
    StereoMatcher matcher;
    check(matcher.begin(left.view(), right.view(), left_mask.view(), right_mask.view(), disparities, {}, *workspace,
                        {disparity.view(), error.view()}),
          "stereo");
    check(do_all([&] { return matcher.step(pair.height); }), "stereo");
    check(depth_rows(pair, camera, matcher.result(), 0, a.height, depth), "depth");
  }
  for (std::size_t i = 0; i < sigma.pixels.size(); ++i)
    inverse.pixels[i] = sigma.pixels[i] > 0 ? 1 / inverse.pixels[i] : 0;
  write_pfm(names[3], inverse);
}
