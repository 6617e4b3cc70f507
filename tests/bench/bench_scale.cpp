// What a flight costs for each pixel of its images, as a table: the same flight over the default ground with cameras of
// the same field of view and more and more pixels: bench_scale [WIDTHxHEIGHT...]. Times are of the processor. Sizes
// above the capacities of the build are left out; the profile `large` has them all.
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "bsp/flight/flight_software.hpp"
#include "cfg/limits.hpp"
#include "tests/bench/chain_flight.hpp"

namespace {
using ilp::bench::ChainTimes;

constexpr int frames = 24;
constexpr double usual_focal = 550, usual_width = 640;

struct Size {
  int width = 0, height = 0;
};

class NoReference final : public ilp::bench::Reference {
 public:
  double run() override { return 0; }
};

ChainTimes fly(const Size& size) {
  const std::string focal = std::to_string(usual_focal * size.width / usual_width), place = "bench_scale";
  NoReference none;
  return ilp::bench::fly_chain(frames, none,
                               {{"camera", "width", std::to_string(size.width), place},
                                {"camera", "height", std::to_string(size.height), place},
                                {"camera", "fx", focal, place},
                                {"camera", "fy", focal, place},
                                {"camera", "cx", "-1", place},
                                {"camera", "cy", "-1", place}});
}

double sum_of(const ChainTimes& times, const std::vector<std::string>& parts) {
  double ms = 0;
  for (const std::string& part : parts) ms += times.of(part);
  return ms;
}

void print_row(const Size& size, const ChainTimes& times) {
  const double pixels = static_cast<double>(size.width) * size.height;
  const auto per_pixel = [&](double ms) { return 1e6 * ms / pixels; };
  const double matching = times.of("dense_matcher/match"), dense = times.of("dense_matcher") - matching,
               compressor = times.of("compressor"),
               motion = sum_of(times, {"structure_and_motion", "camera_calibrator", "overlap_checker", "place_memory"});
  std::printf("| %d x %d | %d | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f |\n", size.width, size.height,
              times.keyframes, times.all_ms, per_pixel(times.all_ms), per_pixel(matching), per_pixel(dense),
              per_pixel(compressor), per_pixel(motion),
              per_pixel(times.all_ms - matching - dense - compressor - motion));
  std::fflush(stdout);
}

void print_memory() {
  std::size_t bytes = 0;
  for (const ilp::MemoryRegion& region : ilp::memory_map()) bytes += region.bytes;
  std::printf("\nprofile %s: %zu bytes of static memory, %.0f for each pixel of its largest image (%d x %d)\n",
              ilp::limits::profile, bytes, static_cast<double>(bytes) / ilp::limits::max_image_pixels,
              ilp::limits::max_image_width, ilp::limits::max_image_height);
}

Size size_of(const std::string& text) {
  Size size;
  if (std::sscanf(text.c_str(), "%dx%d", &size.width, &size.height) != 2)
    throw std::invalid_argument(text + ": a size such as 640x480 expected");
  return size;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::vector<Size> sizes;
    for (int i = 1; i < argc; ++i) sizes.push_back(size_of(argv[i]));
    if (sizes.empty()) sizes = {{320, 240}, {640, 480}, {1024, 1024}, {2048, 2048}};
    std::printf(
        "| image | keyframes | all, ms per keyframe | all, ns per pixel | matching | resampling, depth, masks | "
        "compressor | overlap, motion, places | the rest |\n|---|---|---|---|---|---|---|---|---|\n");
    for (const Size& size : sizes) {
      if (size.width > ilp::limits::max_image_width || size.height > ilp::limits::max_image_height) continue;
      print_row(size, fly(size));
    }
    print_memory();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_scale: " << error.what() << "\n";
    return 1;
  }
}
