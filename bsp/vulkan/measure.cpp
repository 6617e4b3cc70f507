#include "bsp/vulkan/measure.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "bsp/vulkan/stopwatch.hpp"
#include "fsw/base/checksum.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 160, height = 120;

/// Samples of one axis that lie over b at a shift.
std::int64_t covered(std::int32_t first, std::int32_t samples, std::int32_t side) {
  const std::int32_t right = first >> 2, there = (side - (first & 3) + 3) >> 2;
  return std::max(std::min(samples, there - right) - std::max(-right, 0), 0);
}

std::int64_t compared_samples(const WidePose& pose) {
  std::int64_t sum = 0;
  for (std::int32_t iy = 0; iy < pose.shifts_y; ++iy) {
    const std::int64_t rows = covered(pose.top + wide_shift_px * iy, pose.rows, height);
    for (std::int32_t ix = 0; ix < pose.shifts_x; ++ix) {
      const std::int64_t area = rows * covered(pose.left + wide_shift_px * ix, pose.columns, width);
      sum += area >= pose.min_count ? area : 0;
    }
  }
  return sum;
}

WideInput input;
WideOutput by_device, by_processor;
WideWorkspace workspace;

}  // namespace

bool measure_wide_search(WideSearchJob& search) {
  make_wide_example(0, input);
  input.width = width;
  input.height = height;
  const WidePlan plan = plan_wide_search(width, height, 0.5);
  double device_s = 0, processor_s = 0;
  std::int64_t samples = 0;
  for (std::int32_t job = 0; job < plan.jobs(); ++job) {
    fill_wide_job(plan, job, input);
    const Stopwatch of_device;
    if (!search.run(memory_of(input), std::as_writable_bytes(std::span(&by_device, 1)))) return false;
    device_s += of_device.seconds();
    const Stopwatch of_processor;
    for (std::size_t k = 0; k < wide_job_poses; ++k) search_wide_pose(input, k, workspace, by_processor.best[k]);
    processor_s += of_processor.seconds();
    for (const WidePose& pose : input.poses) samples += compared_samples(pose);
    if (std::memcmp(&by_device, &by_processor, sizeof(by_device)) != 0) {
      std::printf("job %d: the bytes of the device are not those of the processor\n", job);
      return false;
    }
  }
  std::printf("%d poses in %d jobs, %.2f G samples compared, %zu bytes in and %zu bytes out per job\n", plan.poses(),
              plan.jobs(), 1e-9 * static_cast<double>(samples), sizeof(input), sizeof(by_device));
  std::printf("device %.3f s, processor %.3f s, all bytes equal\n", device_s, processor_s);
  return true;
}

}  // namespace ilp
