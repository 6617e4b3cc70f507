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
bool same_update(const Status& one, const Status& other) {
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

void report(CameraReports& reports, const Status& status) {
  // The first reports matter most.
  static_cast<void>(reports.updates.push_back(status));
}

bool next_update(CameraReports& reports, Status& updates) {
  if (reports.updates.empty()) return false;
  updates = reports.updates[0];
  reports.updates.erase(0);
  return true;
}

void report_tallies(CameraReports& reports, TimeNs now) {
  const bool any = reports.refused.count > 0 || reports.stamps.count > 0 || reports.gaps.count > 0;
  if (!any || (reports.tallied && now - reports.tallied_ns < between_tallies_ns)) return;
  reports.tallied = true;
  reports.tallied_ns = now;
  if (reports.refused.count > 0)
    report(reports, {StatusCode::camera_frames_refused, reports.refused.count, reports.refused.latest});
  if (reports.stamps.count > 0)
    report(reports, {StatusCode::camera_stamps_refused, reports.stamps.count, reports.stamps.latest});
  if (reports.gaps.count > 0) report(reports, {StatusCode::frame_gap, reports.gaps.latest, reports.gaps.count});
  reports.refused = reports.stamps = reports.gaps = {};
}

void refuse_frame(CameraReports& reports, FrameDamage reason) {
  ++reports.refused.count;
  reports.refused.latest = static_cast<std::int64_t>(reason);
}

void recover(CameraOutage& outage, CameraReports& reports, TimeNs now) {
  if (!outage.out) return;
  report(reports, {StatusCode::camera_recovered, (now - outage.since_ns) / ns_per_ms, outage.attempts});
  outage.out = false;
  outage.ever_recovered = true;
  outage.recovered_ns = now;
}

std::span<const std::uint8_t> bytes_of(const BufferPool& pool, const VideoFormat& format, const VideoBuffer& buffer) {
  const std::span<const std::uint8_t> bytes = pool.bytes(buffer.index);
  return format.pixel.packing == Packing::jpeg ? bytes.first(std::min(buffer.bytes_used, bytes.size())) : bytes;
}

bool damaged(const BufferPool& pool, const VideoFormat& format, const VideoBuffer& buffer, CameraReports& reports) {
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
    refuse_frame(reports, FrameDamage::flagged);
  } else if (buffer.bytes_used < format.image_bytes) {
    refuse_frame(reports, FrameDamage::too_short);
  } else if (buffer.bytes_used > pool.bytes(buffer.index).size()) {
    refuse_frame(reports, FrameDamage::too_long);
  } else if (format.pixel.packing == Packing::jpeg && !begins_as_jpeg(pool.bytes(buffer.index))) {
    refuse_frame(reports, FrameDamage::undecodable);
  } else {
    return false;
  }
  return true;
}

TimeNs mission_time(const VideoBuffer& buffer, TimeNs mission_minus_monotonic) {
  const bool sane = buffer.stamp_s >= 0 && buffer.stamp_s < stamp_seconds_limit && buffer.stamp_us >= 0 &&
                    buffer.stamp_us < 1'000'000;
  if (!sane) return no_stamp;
  return buffer.stamp_s * ns_per_s + buffer.stamp_us * ns_per_us + mission_minus_monotonic;
}

void drop(HeldFrames& held, BufferPool& pool, std::size_t which) {
  pool.give_back(held.frames[which].buffer.index);
  held.frames.erase(which);
}

std::size_t nearest_to_wanted(const HeldFrames& held) {
  std::size_t best = 0;
  if (held.wanted_ns == Camera::any_time) return best;
  for (std::size_t i = 1; i < held.frames.size(); ++i) {
    if (distance(held.frames[i].time_ns, held.wanted_ns) < distance(held.frames[best].time_ns, held.wanted_ns))
      best = i;
  }
  return best;
}

ExposureSetting exposure_at(const OwnExposure& exposure, TimeNs exposed_ns, TimeNs period_ns) {
  if (!exposure.set) return {};
  if (exposed_ns < exposure.set_ns) return exposure.before;
  const bool sure = exposed_ns >= exposure.set_ns + periods_until_exposed * period_ns;
  return sure ? exposure.now : ExposureSetting{};
}

Status listen(TimeNs received_ns, TimeNs now, TimeNs period, std::uint32_t sequence) {
  const TimeNs limit = period > 0 ? std::max(periods_until_silent * period, shortest_silence_ns) : unknown_silence_ns;
  if (now - received_ns < limit) return {};
  return {StatusCode::camera_silent, sequence, (now - received_ns) / ns_per_ms};
}

void count_gap(DriverSequence& driver, std::uint32_t sequence, bool believed, CameraTally& gaps) {
  const std::uint32_t step = sequence - driver.latest;
  const bool forward = driver.any && step != 0 && step < 0x8000'0000U;
  if (believed && forward && step > 1) {
    gaps.count += step - 1;
    gaps.latest = sequence;
  }
  driver = {sequence, true};
}

bool decided(const HeldFrames& held, TimeNs empty_ns, TimeNs granularity) {
  if (!held.wanted || held.frames.empty()) return false;
  // If the driver has no frame after the wanted time, the earlier ones are all there are.
  return held.frames.back().time_ns >= held.wanted_ns || empty_ns > held.wanted_ns + granularity;
}

void apply_exposure(VideoDevice& device, std::int64_t gain_unit, Clock& clock, OwnExposure& exposure) {
  // After an outage the camera may have settings of its own again.
  ExposureRange range;
  ExposureSetting setting = exposure.asked;
  exposure.before = exposure.now = {};
  if (!find_exposure_range(device, gain_unit, range).ok()) return;
  if (!write_exposure(device, gain_unit, setting).ok()) return;
  exposure.now = setting;
  exposure.set_ns = clock.now();
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

/// A device that comes back may be another one.
void V4l2Camera::meet(const DeviceName& name) {
  if (ever_delivered_ && name != name_) {
    if (name != first_name_) report(reports_, StatusCode::camera_changed);
    known_ = false;
    verdict_ = {};
    frame_clock_.forget();
  }
  name_ = name;
}

Status V4l2Camera::advance_from(Stage stage, TimeNs now) {
  // Reports of a device's first start also hold for later ones.
  CameraUpdates known_already;
  CameraUpdates& updates = known_ ? known_already : reports_.updates;
  if (stage == Stage::closed) {
    const int error = device_.open(options_.device);
    if (error != 0) return {StatusCode::camera_absent, error};
    stage_ = Stage::open;
  } else if (stage == Stage::open) {
    DeviceName name;
    ILP_TRY(check_capabilities(device_, name));
    meet(name);
    ILP_TRY(negotiate(device_, options_, width_, height_, format_, updates));
    stage_ = Stage::agreed;
  } else if (stage == Stage::agreed) {
    set_controls(device_, options_, updates);
    if (exposure_.set) apply_exposure(device_, options_.gain_unit, clock_, exposure_);
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
  driver_sequence_.any = false;
  received_ns_ = empty_ns_ = now;
}

Status V4l2Camera::advance(TimeNs now) {
  if (now < outage_.retry_ns) return StatusCode::not_ready;
  const Status status = advance_from(stage_, now);
  return status.ok() ? Status{StatusCode::not_ready} : fail(status, now);
}

void V4l2Camera::let_go() {
  held_.frames.clear();
  pool_.release();
  device_.close();
  stage_ = Stage::closed;
}

Status V4l2Camera::fail(const Status& reason, TimeNs now) {
  outage_.latest = reason;
  if (!outage_.out) {
    outage_.out = true;
    outage_.since_ns = now;
    const bool another = !outage_.ever_recovered || now - outage_.recovered_ns > pauses_of_health * outage_.pause_ns;
    if (another) {
      outage_.attempts = 0;
      outage_.pause_ns = first_pause_ns;
      outage_.reported = {};
    }
  }
  ++outage_.attempts;
  const bool close = device_is_gone(reason) || is_refusal(reason) || outage_.attempts > restarts_before_reopening;
  if (close) {
    let_go();
  } else {
    held_.frames.clear();
    pool_.release();
    stage_ = Stage::open;
  }
  outage_.retry_ns = now;
  if (outage_.attempts > 1 || device_is_gone(reason)) {
    outage_.retry_ns = now + outage_.pause_ns;
    outage_.pause_ns = std::min(2 * outage_.pause_ns, longest_pause_ns);
  }
  if (same_update(reason, outage_.reported)) return StatusCode::not_ready;
  outage_.reported = reason;
  return reason;
}

void V4l2Camera::grade(const FrameArrival& arrival) {
  grade_.evaluate(arrival);
  if (!grade_.complete()) return;
  grading_ = false;
  const CameraVerdict before = verdict_;
  verdict_ = grade_.verdict();
  frame_clock_.believe(verdict_);
  if (before.frames > 0 && before.findings == verdict_.findings) return;
  const bool believed = verdict_.stamps_believed && verdict_.sequence_believed;
  report(reports_, {believed ? StatusCode::camera_graded : StatusCode::camera_distrusted, verdict_.findings,
                    verdict_.period_ns / ns_per_us});
}

bool V4l2Camera::evaluate(const VideoBuffer& buffer, TimeNs now, HeldFrame& frame) {
  received_ns_ = now;
  FrameArrival arrival;
  arrival.stamp_ns = mission_time(buffer, mission_minus_monotonic_);
  arrival.empty_ns = empty_ns_;
  arrival.now_ns = now;
  arrival.arrival_ns = frame_clock_.arrival(empty_ns_, now);
  arrival.sequence = buffer.sequence;
  arrival.damaged = damaged(pool_, format_, buffer, reports_);
  if (consistent_ < consistent_frames) {
    consistent_ = arrival.damaged ? 0 : consistent_ + 1;
    if (consistent_ == consistent_frames) {
      if (!ever_delivered_) first_name_ = name_;
      ever_delivered_ = known_ = true;
      recover(outage_, reports_, now);
    }
    return false;
  }
  count_gap(driver_sequence_, buffer.sequence, verdict_.sequence_believed, reports_.gaps);
  if (grading_) {
    if (!arrival.damaged && format_.pixel.packing == Packing::jpeg) {
      sample_file(bytes_of(pool_, format_, buffer), arrival);
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
    ++reports_.stamps.count;
    reports_.stamps.latest = (arrival.stamp_ns - arrival.arrival_ns) / ns_per_us;
  }
  return true;
}

Status V4l2Camera::collect() {
  const std::size_t most = std::min(limits::max_held_frames, pool_.count() - 1);
  for (std::size_t i = 0; i < pool_.count() && !decided(held_, empty_ns_, granularity()); ++i) {
    const TimeNs asked = clock_.now();
    VideoBuffer buffer;
    const Status taken = pool_.take(buffer);
    if (taken.is(StatusCode::not_ready)) {
      empty_ns_ = asked;
      return listen(received_ns_, asked, frame_clock_.period(), driver_sequence_.latest);
    }
    ILP_TRY(taken);
    HeldFrame frame;
    if (!evaluate(buffer, clock_.now(), frame) || !held_.frames.push_back(frame)) pool_.give_back(buffer.index);
    // Once it is decided, one more is held until the nearest has been delivered.
    if (held_.frames.size() > most && !decided(held_, empty_ns_, granularity())) drop(held_, pool_, 0);
  }
  return {};
}

TimeNs V4l2Camera::granularity() const {
  return std::max(2 * frame_clock_.period(), least_granularity_ns);
}

Status V4l2Camera::trigger(TimeNs time) {
  held_.wanted = time == any_time || time != held_.hopeless_ns;
  held_.wanted_ns = time;
  return {};
}

Status V4l2Camera::deliver(FrameImage& image, CameraFrame& frame) {
  const std::size_t chosen = nearest_to_wanted(held_);
  if (held_.wanted_ns != any_time && distance(held_.frames[chosen].time_ns, held_.wanted_ns) > granularity()) {
    held_.hopeless_ns = held_.wanted_ns;
    held_.wanted = false;
    return StatusCode::not_ready;
  }
  const HeldFrame taken = held_.frames[chosen];
  ILP_TRY(image.resize(reduction_.width, reduction_.height));
  const Status converted = converter_.convert(
      {format_.pixel, bytes_of(pool_, format_, taken.buffer), format_.width, format_.height, format_.stride},
      reduction_, image.view());
  if (!converted.ok()) {
    // The nearest of the other frames is the answer.
    refuse_frame(reports_, FrameDamage::undecodable);
    drop(held_, pool_, chosen);
    return StatusCode::not_ready;
  }
  held_.wanted = false;
  for (std::size_t i = 0; i <= chosen; ++i) drop(held_, pool_, 0);
  frame = {};
  frame.time_ns = taken.time_ns;
  frame.sequence = ++sequence_;
  FixedText<sizeof(frame.name)> name;
  name.add("video-").add(static_cast<std::int64_t>(taken.buffer.sequence), 6).add('-');
  name.add(time_meaning_text(taken.meaning));
  frame.exposure = exposure_at(exposure_, taken.time_ns, frame_clock_.period());
  if (frame.exposure.known()) {
    name.add('-').add(frame.exposure.exposure_us).add("us-gain").add(frame.exposure.gain_milli);
  }
  copy_text(frame.name, name.c_str());
  return {};
}

Status V4l2Camera::exposure_range(ExposureRange& range) {
  if (stage_ != Stage::streaming) return StatusCode::not_ready;
  ILP_TRY(find_exposure_range(device_, options_.gain_unit, range));
  if (exposure_.set) return {};
  exposure_.now = {};
  const std::int64_t named = options_.exposure_us == V4l2Options::as_it_is ? first_exposure_us : options_.exposure_us;
  ExposureSetting first{std::clamp(named, range.least_us, range.most_us), range.least_gain_milli};
  return set_exposure(first);
}

Status V4l2Camera::set_exposure(ExposureSetting& setting) {
  if (stage_ != Stage::streaming) return StatusCode::not_ready;
  exposure_.asked = setting;
  ILP_TRY(write_exposure(device_, options_.gain_unit, setting));
  exposure_.set = true;
  exposure_.before = exposure_.now;
  exposure_.now = setting;
  exposure_.set_ns = clock_.now();
  return {};
}

Status V4l2Camera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  frame = {};
  report_tallies(reports_, now);
  Status status;
  if (next_update(reports_, status)) return status;
  if (stage_ != Stage::streaming) return advance(now);
  status = collect();
  if (!status.ok()) return fail(status, now);
  if (!decided(held_, empty_ns_, granularity())) return StatusCode::not_ready;
  return deliver(image, frame);
}

Status V4l2Camera::prepare(TimeNs limit) {
  const TimeNs end = clock_.now() + limit;
  outage_.latest = {};
  // Bounded even if the clock stops: every turn examines a frame or sleeps.
  for (TimeNs turn = 0; turn < limit / ns_per_ms && verdict_.frames == 0 && !is_refusal(outage_.latest); ++turn) {
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
      if (now < outage_.retry_ns) clock_.sleep_until(now + start_up_step_ns);
    }
    if (!status.ok() && !status.is(StatusCode::not_ready)) report(reports_, status);
  }
  if (verdict_.frames > 0) return {};
  return outage_.latest.ok() ? Status{StatusCode::not_ready} : outage_.latest;
}

}  // namespace ilp
