#include "bsp/linux/video_camera.hpp"

#include <cstdio>
#include <cstring>

#include "bsp/linux/status_line.hpp"
#include "fsw/base/text.hpp"

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
    if ((verdict.findings >> bit & 1U) != 0) std::fprintf(stderr, "camera: %s\n", finding::texts[bit]);
  }
  if (!verdict.stamps_believed) std::fputs("camera: times are those of the frames' arrival\n", stderr);
}

void print_formats() {
  std::fputs("camera: the flight understands", stderr);
  for (const PixelFormat& format : pixel_formats()) {
    const FourccText code = fourcc_text(format.fourcc);
    const bool two_names = std::strcmp(code.text, format.name) != 0;
    std::fprintf(stderr, " %s%s%s%s", format.name, two_names ? " (" : "", two_names ? code.text : "",
                 two_names ? ")" : "");
  }
  std::fputs("\n", stderr);
}

/// Names a pixel format in `settings` that is none of ours.
void explain_format(const char* settings) {
  constexpr const char* key = ",format=";
  const char* const found = std::strstr(settings, key);
  if (found == nullptr) return;
  const char* const begin = found + std::strlen(key);
  FixedText<64> name;
  for (const char* c = begin; *c != 0 && *c != ','; ++c) name.add(*c);
  if (!name.overflow() && find_pixel_format(name.c_str()) != nullptr) return;
  std::fprintf(stderr, "camera: %s is no pixel format of the flight\n", name.c_str());
  print_formats();
}

void explain_refusal(const Status& status) {
  if (!status.is(StatusCode::unsupported_format)) return;
  std::fprintf(stderr, "camera: the device offers %s\n", fourcc_text(static_cast<std::uint32_t>(status.a)).text);
  print_formats();
}

Status parse_settings(const char* settings, V4l2Options& options) {
  const Status status = parse_v4l2_options(settings, options);
  if (!status.ok()) explain_format(settings);
  return status;
}

}  // namespace

Status start_video_camera(const char* settings, std::int32_t width, std::int32_t height, const RealClock& clock,
                          V4l2Camera& camera) {
  V4l2Options options;
  ILP_TRY(parse_settings(settings, options));
  ILP_TRY(camera.configure(options, width, height, clock.mission_minus_monotonic()));
  const Status status = camera.prepare(patience_ns);
  if (is_refusal(status)) {
    explain_refusal(status);
    return status;
  }
  if (status.ok()) {
    print_verdict(camera);
  } else {
    std::fprintf(stderr, "camera: %s; the flight goes on and tries again\n", status_words(status).c_str());
  }
  return {};
}

Status find_video_size(const char* settings, VideoDevice& device, std::int32_t& width, std::int32_t& height) {
  V4l2Options options;
  ILP_TRY(parse_settings(settings, options));
  return present_size(device, options, width, height);
}

}  // namespace ilp
