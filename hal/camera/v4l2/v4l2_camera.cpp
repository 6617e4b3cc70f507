#include "hal/camera/v4l2/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>

#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"

namespace ilp {
namespace {

// After a start the first frames may be half exposed, or of the previous stream.
constexpr std::int32_t consistent_frames = 3;
// A free camera counts as silent after this many periods, and not before the shortest time.
constexpr TimeNs periods_until_silent = 5;
constexpr TimeNs shortest_silence_ns = 2 * ns_per_s;
constexpr TimeNs unknown_silence_ns = 10 * ns_per_s;
// Restarts of the stream before the device is closed; pauses between attempts.
constexpr std::int32_t restarts_before_reopening = 3;
constexpr TimeNs first_pause_ns = 200 * ns_per_ms;
constexpr TimeNs longest_pause_ns = 30 * ns_per_s;
// A stream that has lasted for less than this many of the latest pauses is still in the same outage: pauses keep
// growing, so that failures take at most a tenth of the time of a usable camera.
constexpr TimeNs pauses_of_health = 10;
constexpr TimeNs between_tallies_ns = 10 * ns_per_s;
constexpr TimeNs least_granularity_ns = 40 * ns_per_ms;
constexpr TimeNs start_up_step_ns = 20 * ns_per_ms;
constexpr std::int64_t stamp_seconds_limit = 9'000'000'000;
constexpr TimeNs no_stamp = -4'000'000'000 * ns_per_s;

/// A sensor begins the next image, and often the one after it, before it takes a new setting.
constexpr TimeNs periods_until_exposed = 2;
/// The exposure with which the flight's control begins on a camera that is not set to one.
constexpr std::int64_t first_exposure_us = 5000;

bool device_is_gone(const Status& status) {
  return status.is(StatusCode::camera_absent) ||
         (status.is(StatusCode::camera_fault) && (status.a == ENODEV || status.a == ENXIO || status.a == EBADF));
}

/// For most failures the values are counts that differ every time.
bool same_news(const Status& one, const Status& other) {
  return one.code == other.code && (!one.is(StatusCode::camera_fault) || (one.a == other.a && one.b == other.b));
}

/// A fingerprint from some rows of a picture, whose spacing does not match blocks or lines of text.
void sample(std::span<const std::uint8_t> bytes, const VideoFormat& format, FrameArrival& arrival) {
  constexpr std::int32_t row_step = 13;
  const std::size_t length = row_bytes(format.pixel, format.width);
  const std::size_t period = period_bytes(format.pixel);
  arrival.uniform = true;
  for (std::int32_t y = 0; y < format.height; y += row_step) {
    const auto row = bytes.subspan(static_cast<std::size_t>(y) * format.stride, length);
    // In a mosaic, every other row has other colours.
    const std::size_t first = format.pixel.mosaic && y % 2 != 0 ? format.stride : 0;
    arrival.sample_crc = crc32(row, arrival.sample_crc);
    for (std::size_t i = 0; i < length && arrival.uniform; ++i) {
      arrival.uniform = row[i] == bytes[first + i % period];
    }
  }
}

/// The fingerprint of a compressed picture is that of all its bytes.
void sample_file(std::span<const std::uint8_t> bytes, FrameArrival& arrival) {
  arrival.sample_crc = crc32(bytes, arrival.sample_crc);
  arrival.uniform = false;
}

bool begins_as_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 2 && bytes[0] == 0xFF && bytes[1] == 0xD8;
}

}  // namespace

bool is_refusal(const Status& status) {
  return status.is(StatusCode::camera_incapable) || status.is(StatusCode::camera_size) ||
         status.is(StatusCode::camera_layout) || status.is(StatusCode::unsupported_format);
}

V4l2Camera::~V4l2Camera() {
  let_go();
}

Status V4l2Camera::configure(const V4l2Options& options, std::int32_t width, std::int32_t height,
                             TimeNs mission_minus_monotonic) {
  ILP_TRY(find_reduction(width, height, reduction_));
  if (reduction_.width < limits::min_image_side || reduction_.height < limits::min_image_side) {
    return {StatusCode::image_too_large, width, height};
  }
  options_ = options;
  width_ = width;
  height_ = height;
  mission_minus_monotonic_ = mission_minus_monotonic;
  return {};
}

void V4l2Camera::tell(const Status& status) {
  // The first reports matter most.
  static_cast<void>(news_.push_back(status));
}

bool V4l2Camera::next_news(Status& news) {
  if (news_.empty()) return false;
  news = news_[0];
  for (std::size_t i = 1; i < news_.size(); ++i) news_[i - 1] = news_[i];
  news_.pop_back();
  return true;
}

void V4l2Camera::tell_tallies(TimeNs now) {
  const bool any = refused_.count > 0 || stamps_.count > 0 || gaps_.count > 0;
  if (!any || (tallied_ && now - tallied_ns_ < between_tallies_ns)) return;
  tallied_ = true;
  tallied_ns_ = now;
  if (refused_.count > 0) tell({StatusCode::camera_frames_refused, refused_.count, refused_.latest});
  if (stamps_.count > 0) tell({StatusCode::camera_stamps_refused, stamps_.count, stamps_.latest});
  if (gaps_.count > 0) tell({StatusCode::frame_gap, gaps_.latest, gaps_.count});
  refused_ = stamps_ = gaps_ = {};
}

/// A device that comes back may be another one.
void V4l2Camera::meet(const DeviceName& name) {
  if (ever_delivered_ && name != name_) {
    if (name != first_name_) tell(StatusCode::camera_changed);
    known_ = false;
    verdict_ = {};
    frame_clock_.forget();
  }
  name_ = name;
}

Status V4l2Camera::advance_from(Stage stage, TimeNs now) {
  // Reports of a device's first start also hold for later ones.
  CameraNews known_already;
  CameraNews& news = known_ ? known_already : news_;
  if (stage == Stage::closed) {
    const int error = device_.open(options_.device);
    if (error != 0) return {StatusCode::camera_absent, error};
    stage_ = Stage::open;
  } else if (stage == Stage::open) {
    DeviceName name;
    ILP_TRY(check_capabilities(device_, name));
    meet(name);
    ILP_TRY(negotiate(device_, options_, width_, height_, format_, news));
    stage_ = Stage::agreed;
  } else if (stage == Stage::agreed) {
    set_controls(device_, options_, news);
    if (sets_exposure_) apply_exposure();
    ILP_TRY(pool_.allocate(format_.image_bytes));
    stage_ = Stage::mapped;
  } else if (stage == Stage::mapped) {
    ILP_TRY(pool_.start());
    stage_ = Stage::streaming;
    begin_stream(now);
  }
  return {};
}

void V4l2Camera::begin_stream(TimeNs now) {
  const TimeNs us = options_.stamp_delay_us;
  frame_clock_.begin(format_.period_ns, us == V4l2Options::as_it_is ? -1 : us * ns_per_us);
  grade_.begin(format_.period_ns);
  grading_ = true;
  consistent_ = 0;
  any_sequence_ = false;
  heard_ns_ = empty_ns_ = now;
}

Status V4l2Camera::advance(TimeNs now) {
  if (now < retry_ns_) return StatusCode::not_ready;
  const Status status = advance_from(stage_, now);
  return status.ok() ? Status{StatusCode::not_ready} : fail(status, now);
}

void V4l2Camera::let_go() {
  held_.clear();
  pool_.release();
  device_.close();
  stage_ = Stage::closed;
}

Status V4l2Camera::fail(const Status& reason, TimeNs now) {
  latest_failure_ = reason;
  if (!out_) {
    out_ = true;
    out_since_ns_ = now;
    const bool another = !ever_recovered_ || now - recovered_ns_ > pauses_of_health * pause_ns_;
    if (another) {
      attempts_ = 0;
      pause_ns_ = first_pause_ns;
      told_failure_ = {};
    }
  }
  ++attempts_;
  const bool close = device_is_gone(reason) || is_refusal(reason) || attempts_ > restarts_before_reopening;
  if (close) {
    let_go();
  } else {
    held_.clear();
    pool_.release();
    stage_ = Stage::open;
  }
  retry_ns_ = now;
  if (attempts_ > 1 || device_is_gone(reason)) {
    retry_ns_ = now + pause_ns_;
    pause_ns_ = std::min(2 * pause_ns_, longest_pause_ns);
  }
  if (same_news(reason, told_failure_)) return StatusCode::not_ready;
  told_failure_ = reason;
  return reason;
}

void V4l2Camera::recover(TimeNs now) {
  if (!ever_delivered_) first_name_ = name_;
  ever_delivered_ = known_ = true;
  if (!out_) return;
  tell({StatusCode::camera_recovered, (now - out_since_ns_) / ns_per_ms, attempts_});
  out_ = false;
  ever_recovered_ = true;
  recovered_ns_ = now;
}

Status V4l2Camera::listen(TimeNs now) const {
  const TimeNs period = frame_clock_.period();
  const TimeNs limit = period > 0 ? std::max(periods_until_silent * period, shortest_silence_ns) : unknown_silence_ns;
  if (now - heard_ns_ < limit) return {};
  return {StatusCode::camera_silent, driver_sequence_, (now - heard_ns_) / ns_per_ms};
}

void V4l2Camera::refuse_frame(FrameDamage reason) {
  ++refused_.count;
  refused_.latest = static_cast<std::int64_t>(reason);
}

std::span<const std::uint8_t> V4l2Camera::bytes_of(const VideoBuffer& buffer) const {
  const std::span<const std::uint8_t> bytes = pool_.bytes(buffer.index);
  return format_.pixel.packing == Packing::jpeg ? bytes.first(std::min(buffer.bytes_used, bytes.size())) : bytes;
}

bool V4l2Camera::damaged(const VideoBuffer& buffer) {
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
    refuse_frame(FrameDamage::flagged);
  } else if (buffer.bytes_used < format_.image_bytes) {
    refuse_frame(FrameDamage::too_short);
  } else if (buffer.bytes_used > pool_.bytes(buffer.index).size()) {
    refuse_frame(FrameDamage::too_long);
  } else if (format_.pixel.packing == Packing::jpeg && !begins_as_jpeg(pool_.bytes(buffer.index))) {
    refuse_frame(FrameDamage::undecodable);
  } else {
    return false;
  }
  return true;
}

TimeNs V4l2Camera::mission_time(const VideoBuffer& buffer) const {
  const bool sane = buffer.stamp_s >= 0 && buffer.stamp_s < stamp_seconds_limit && buffer.stamp_us >= 0 &&
                    buffer.stamp_us < 1'000'000;
  if (!sane) return no_stamp;
  return buffer.stamp_s * ns_per_s + buffer.stamp_us * ns_per_us + mission_minus_monotonic_;
}

void V4l2Camera::grade(const FrameArrival& arrival) {
  grade_.look_at(arrival);
  if (!grade_.complete()) return;
  grading_ = false;
  const CameraVerdict before = verdict_;
  verdict_ = grade_.verdict();
  frame_clock_.believe(verdict_);
  if (before.frames > 0 && before.findings == verdict_.findings) return;
  const bool believed = verdict_.stamps_believed && verdict_.sequence_believed;
  tell({believed ? StatusCode::camera_graded : StatusCode::camera_distrusted, verdict_.findings,
        verdict_.period_ns / ns_per_us});
}

void V4l2Camera::count_gap(std::uint32_t sequence) {
  const std::uint32_t step = sequence - driver_sequence_;
  const bool forward = any_sequence_ && step != 0 && step < 0x8000'0000U;
  if (verdict_.sequence_believed && forward && step > 1) {
    gaps_.count += step - 1;
    gaps_.latest = sequence;
  }
  driver_sequence_ = sequence;
  any_sequence_ = true;
}

bool V4l2Camera::look_at(const VideoBuffer& buffer, TimeNs now, Held& frame) {
  heard_ns_ = now;
  FrameArrival arrival;
  arrival.stamp_ns = mission_time(buffer);
  arrival.empty_ns = empty_ns_;
  arrival.now_ns = now;
  arrival.arrival_ns = frame_clock_.arrival(empty_ns_, now);
  arrival.sequence = buffer.sequence;
  arrival.damaged = damaged(buffer);
  if (consistent_ < consistent_frames) {
    consistent_ = arrival.damaged ? 0 : consistent_ + 1;
    if (consistent_ == consistent_frames) recover(now);
    return false;
  }
  count_gap(buffer.sequence);
  if (grading_) {
    if (!arrival.damaged && format_.pixel.packing == Packing::jpeg) {
      sample_file(bytes_of(buffer), arrival);
    } else if (!arrival.damaged) {
      sample(pool_.bytes(buffer.index), format_, arrival);
    }
    grade(arrival);
  }
  if (arrival.damaged || verdict_.frames == 0) return false;
  const bool end_of_frame = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) != V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  bool refused = false;
  frame.buffer = buffer;
  frame.time_ns = frame_clock_.exposure(arrival, end_of_frame, frame.meaning, refused);
  if (refused) {
    ++stamps_.count;
    stamps_.latest = (arrival.stamp_ns - arrival.arrival_ns) / ns_per_us;
  }
  return true;
}

Status V4l2Camera::collect() {
  const std::size_t most = std::min(limits::max_held_frames, pool_.count() - 1);
  for (std::size_t i = 0; i < pool_.count() && !decided(); ++i) {
    const TimeNs asked = clock_.now();
    VideoBuffer buffer;
    const Status taken = pool_.take(buffer);
    if (taken.is(StatusCode::not_ready)) {
      empty_ns_ = asked;
      return listen(asked);
    }
    ILP_TRY(taken);
    Held frame;
    if (!look_at(buffer, clock_.now(), frame) || !held_.push_back(frame)) pool_.give_back(buffer.index);
    // Once it is decided, one more is held until the nearest has been delivered.
    if (held_.size() > most && !decided()) drop(0);
  }
  return {};
}

void V4l2Camera::drop(std::size_t which) {
  pool_.give_back(held_[which].buffer.index);
  for (std::size_t i = which + 1; i < held_.size(); ++i) held_[i - 1] = held_[i];
  held_.pop_back();
}

TimeNs V4l2Camera::granularity() const {
  return std::max(2 * frame_clock_.period(), least_granularity_ns);
}

Status V4l2Camera::trigger(TimeNs time) {
  wanted_ = time == any_time || time != hopeless_ns_;
  wanted_ns_ = time;
  return {};
}

bool V4l2Camera::decided() const {
  if (!wanted_ || held_.empty()) return false;
  // If the driver has no frame after the wanted time, the earlier ones are all there are.
  return held_.back().time_ns >= wanted_ns_ || empty_ns_ > wanted_ns_ + granularity();
}

std::size_t V4l2Camera::nearest_to_wanted() const {
  std::size_t best = 0;
  if (wanted_ns_ == any_time) return best;
  for (std::size_t i = 1; i < held_.size(); ++i) {
    if (distance(held_[i].time_ns, wanted_ns_) < distance(held_[best].time_ns, wanted_ns_)) best = i;
  }
  return best;
}

Status V4l2Camera::deliver(FrameImage& image, CameraFrame& frame) {
  const std::size_t chosen = nearest_to_wanted();
  if (wanted_ns_ != any_time && distance(held_[chosen].time_ns, wanted_ns_) > granularity()) {
    hopeless_ns_ = wanted_ns_;
    wanted_ = false;
    return StatusCode::not_ready;
  }
  const Held taken = held_[chosen];
  ILP_TRY(image.resize(reduction_.width, reduction_.height));
  const Status converted = converter_.convert(
      {format_.pixel, bytes_of(taken.buffer), format_.width, format_.height, format_.stride}, reduction_, image.view());
  if (!converted.ok()) {
    // The nearest of the other frames is the answer.
    refuse_frame(FrameDamage::undecodable);
    drop(chosen);
    return StatusCode::not_ready;
  }
  wanted_ = false;
  for (std::size_t i = 0; i <= chosen; ++i) drop(0);
  frame = {};
  frame.time_ns = taken.time_ns;
  frame.sequence = ++sequence_;
  FixedText<sizeof(frame.name)> name;
  name.add("video-").add(static_cast<std::int64_t>(taken.buffer.sequence), 6).add('-');
  name.add(time_meaning_text(taken.meaning));
  frame.exposure = exposure_at(taken.time_ns);
  if (frame.exposure.known()) {
    name.add('-').add(frame.exposure.exposure_us).add("us-gain").add(frame.exposure.gain_milli);
  }
  copy_text(frame.name, name.c_str());
  return {};
}

Status V4l2Camera::exposure_range(ExposureRange& range) {
  if (stage_ != Stage::streaming) return StatusCode::not_ready;
  ILP_TRY(find_exposure_range(device_, options_.gain_unit, range));
  if (sets_exposure_) return {};
  exposure_ = {};
  const std::int64_t named = options_.exposure_us == V4l2Options::as_it_is ? first_exposure_us : options_.exposure_us;
  ExposureSetting first{std::clamp(named, range.least_us, range.most_us), range.least_gain_milli};
  return set_exposure(first);
}

Status V4l2Camera::set_exposure(ExposureSetting& setting) {
  if (stage_ != Stage::streaming) return StatusCode::not_ready;
  asked_ = setting;
  ILP_TRY(write_exposure(device_, options_.gain_unit, setting));
  sets_exposure_ = true;
  exposure_before_ = exposure_;
  exposure_ = setting;
  exposure_set_ns_ = clock_.now();
  return {};
}

void V4l2Camera::apply_exposure() {
  // After an outage the camera may have settings of its own again.
  ExposureRange range;
  ExposureSetting setting = asked_;
  exposure_before_ = exposure_ = {};
  if (!find_exposure_range(device_, options_.gain_unit, range).ok()) return;
  if (!write_exposure(device_, options_.gain_unit, setting).ok()) return;
  exposure_ = setting;
  exposure_set_ns_ = clock_.now();
}

ExposureSetting V4l2Camera::exposure_at(TimeNs exposed_ns) const {
  if (!sets_exposure_) return {};
  if (exposed_ns < exposure_set_ns_) return exposure_before_;
  const bool sure = exposed_ns >= exposure_set_ns_ + periods_until_exposed * frame_clock_.period();
  return sure ? exposure_ : ExposureSetting{};
}

Status V4l2Camera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  frame = {};
  tell_tallies(now);
  Status status;
  if (next_news(status)) return status;
  if (stage_ != Stage::streaming) return advance(now);
  status = collect();
  if (!status.ok()) return fail(status, now);
  if (!decided()) return StatusCode::not_ready;
  return deliver(image, frame);
}

Status V4l2Camera::prepare(TimeNs limit) {
  const TimeNs end = clock_.now() + limit;
  latest_failure_ = {};
  // Bounded even if the clock stops: every turn examines a frame or sleeps.
  for (TimeNs turn = 0; turn < limit / ns_per_ms && verdict_.frames == 0 && !is_refusal(latest_failure_); ++turn) {
    const TimeNs now = clock_.now();
    if (now >= end) break;
    Status status;
    if (stage_ == Stage::streaming) {
      bool readable = false;
      static_cast<void>(device_.wait(static_cast<int>(start_up_step_ns / ns_per_ms), readable));
      status = collect();
      if (!status.ok()) status = fail(status, now);
    } else {
      status = advance(now);
      if (now < retry_ns_) clock_.sleep_until(now + start_up_step_ns);
    }
    if (!status.ok() && !status.is(StatusCode::not_ready)) tell(status);
  }
  if (verdict_.frames > 0) return {};
  return latest_failure_.ok() ? Status{StatusCode::not_ready} : latest_failure_;
}

}  // namespace ilp
