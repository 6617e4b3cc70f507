#include "sim/sil/faulty_camera.hpp"

#include <algorithm>
#include <cmath>

namespace ilp::sil {
namespace {

/// Running mean along a row or a column, `step` elements apart.
void blur_line(std::uint8_t* line, std::int32_t length, std::ptrdiff_t step, int radius,
               std::vector<std::uint8_t>& copy) {
  copy.resize(static_cast<std::size_t>(length));
  for (std::int32_t i = 0; i < length; ++i) copy[static_cast<std::size_t>(i)] = line[i * step];
  const auto at = [&](std::int32_t i) { return int{copy[static_cast<std::size_t>(std::clamp(i, 0, length - 1))]}; };
  const int size = 2 * radius + 1;
  int sum = 0;
  for (int i = -radius; i <= radius; ++i) sum += at(i);
  for (std::int32_t i = 0; i < length; ++i) {
    line[i * step] = static_cast<std::uint8_t>((sum + radius) / size);
    sum += at(i + radius + 1) - at(i - radius);
  }
}

void fill(FrameImage& image, std::uint8_t value) {
  const ImageView<std::uint8_t> view = image.view();
  std::fill_n(view.data, view.area(), value);
}

}  // namespace

void blur(ImageView<std::uint8_t> image, int radius_px) {
  std::vector<std::uint8_t> copy;
  for (int pass = 0; pass < 2; ++pass) {
    for (std::int32_t y = 0; y < image.height; ++y) blur_line(image.row(y), image.width, 1, radius_px, copy);
    for (std::int32_t x = 0; x < image.width; ++x) {
      blur_line(image.data + x, image.height, image.stride, radius_px, copy);
    }
  }
}

FaultyCamera::FaultyCamera(Camera& camera, const FaultPlan& plan, std::uint64_t seed)
    : camera_(camera), plan_(plan), seed_(seed) {}

bool FaultyCamera::strikes_frame(const char* kind, double share, const CameraFrame& frame) const {
  return strikes(seed_, kind, frame.sequence, share);
}

void FaultyCamera::hold(TimeNs due, const FrameImage& image, const CameraFrame& frame) {
  const GrayView view = image.view();
  const auto place =
      std::upper_bound(held_.begin(), held_.end(), due, [](TimeNs time, const Held& held) { return time < held.due; });
  held_.insert(place, {due, frame, view.width, view.height, {view.data, view.data + view.area()}});
}

bool FaultyCamera::release(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (held_.empty() || held_.front().due > now) return false;
  const Held& held = held_.front();
  frame = held.frame;
  // It came out of an image of the same capacity.
  static_cast<void>(image.resize(held.width, held.height));
  std::copy(held.pixels.begin(), held.pixels.end(), image.view().data);
  held_.pop_front();
  return true;
}

void FaultyCamera::spoil_image(FrameImage& image, const CameraFrame& frame) {
  if (strikes_frame("black", plan_.black_share, frame)) {
    fill(image, 0);
    ++counts_.black;
  } else if (strikes_frame("saturated", plan_.saturated_share, frame)) {
    fill(image, 255);
    ++counts_.saturated;
  } else if (strikes_frame("blurred", plan_.blurred_share, frame)) {
    blur(image.view(), plan_.blur_radius_px);
    ++counts_.blurred;
  }
}

FaultyCamera::Fate FaultyCamera::spoil_way(const FrameImage& image, CameraFrame& frame) {
  if (strikes_frame("late", plan_.late_share, frame)) {
    hold(frame.time_ns + nanoseconds(plan_.late_by_s), image, frame);
    ++counts_.late;
    return Fate::swallowed;
  }
  if (strikes_frame("misstamped", plan_.misstamped_share, frame)) {
    frame.time_ns += nanoseconds(plan_.misstamped_by_s);
    ++counts_.misstamped;
  } else if (strikes_frame("duplicated", plan_.duplicated_share, frame)) {
    hold(frame.time_ns, image, frame);
    ++counts_.duplicated;
  }
  return Fate::passed;
}

Status FaultyCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (release(now, image, frame)) return {};
  // Bounded by the frames that the camera holds ready.
  for (;;) {
    const Status status = camera_.capture(now, image, frame);
    if (status.is(StatusCode::end_of_stream)) {
      source_ended_ = true;
      return held_.empty() ? status : Status{StatusCode::not_ready};
    }
    if (status.is(StatusCode::not_ready)) return status;
    newest_sequence_ = std::max(newest_sequence_, frame.sequence);
    if (!status.ok()) return status;
    if (inside_window(frame.time_ns, camera_dead(plan_))) {
      ++counts_.dead;
    } else if (strikes_frame("lost", plan_.lost_share, frame)) {
      ++counts_.lost;
    } else {
      spoil_image(image, frame);
      if (spoil_way(image, frame) == Fate::passed) return {};
    }
  }
}

TimeNs FaultyCamera::next_due() const {
  const TimeNs next = camera_.next_due();
  if (held_.empty()) return next;
  return next == 0 ? held_.front().due : std::min(next, held_.front().due);
}

}  // namespace ilp::sil
