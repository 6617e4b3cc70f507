#include "bsp/linux/video_camera.hpp"

#include <cstdio>

#include "bsp/linux/status_line.hpp"

namespace ilp {
namespace {

constexpr TimeNs patience_ns = 5 * ns_per_s;

void print_verdict(const V4l2Camera& camera) {
  const CameraVerdict& verdict = camera.verdict();
  const VideoFormat& format = camera.format();
  std::fprintf(stderr, "camera: %s %d x %d, %.3f frames/s, %d frames looked at, %lld missing\n", format.pixel.name,
               format.width, format.height, verdict.period_ns > 0 ? 1e9 / static_cast<double>(verdict.period_ns) : 0.0,
               verdict.frames, static_cast<long long>(verdict.missing));
  for (int bit = 0; bit < finding::count; ++bit) {
    if ((verdict.findings >> bit & 1U) != 0) std::fprintf(stderr, "camera: %s\n", finding_text(bit));
  }
  if (!verdict.stamps_believed) std::fputs("camera: times are those of the frames' arrival\n", stderr);
}

}  // namespace

Status start_video_camera(const char* settings, const CameraModel& model, const RealClock& clock, V4l2Camera& camera) {
  V4l2Options options;
  ILP_TRY(parse_v4l2_options(settings, options));
  ILP_TRY(camera.configure(options, model.width, model.height, clock.mission_minus_monotonic()));
  const Status status = camera.prepare(patience_ns);
  if (is_refusal(status)) return status;
  if (status.ok()) {
    print_verdict(camera);
  } else {
    std::fprintf(stderr, "camera: %s; the flight goes on and tries again\n", status_sentence(status).c_str());
  }
  return {};
}

Status find_video_size(const char* settings, VideoDevice& device, std::int32_t& width, std::int32_t& height) {
  V4l2Options options;
  ILP_TRY(parse_v4l2_options(settings, options));
  return present_size(device, options, width, height);
}

}  // namespace ilp
