#include "hal/camera/v4l2/driver_grade.hpp"

#include <algorithm>

namespace ilp {
namespace {

// Reading the clock and taking the frame are two steps, so a stamp from between them is valid.
constexpr TimeNs ahead_tolerance_ns = ns_per_ms;
// No camera stamps earlier than this before the arrival, in addition to its own frame time.
constexpr TimeNs oldest_stamp_ns = ns_per_s;
constexpr TimeNs unknown_period_ns = 2 * ns_per_s;

/// Single errors are reported when they happen; more than a tenth is the driver's habit.
bool habit(std::int64_t cases, std::int64_t frames) {
  return cases * 10 > frames;
}

bool differs_by_a_tenth(TimeNs a, TimeNs b) {
  const TimeNs difference = a > b ? a - b : b - a;
  return difference > b / 10;
}

}  // namespace

std::uint32_t suspicion_of_stamp(const FrameArrival& frame, TimeNs previous_stamp_ns, TimeNs period_ns) {
  const TimeNs period = period_ns > 0 ? period_ns : unknown_period_ns;
  if (frame.stamp_ns > frame.now_ns + ahead_tolerance_ns) {
    return frame.stamp_ns > frame.now_ns + oldest_stamp_ns + 2 * period ? finding::stamps_elsewhere
                                                                        : finding::stamps_ahead;
  }
  if (frame.stamp_ns < frame.empty_ns - oldest_stamp_ns - 2 * period) return finding::stamps_elsewhere;
  return frame.stamp_ns <= previous_stamp_ns ? finding::stamps_stand : 0;
}

void DriverGrade::begin(TimeNs stated_period_ns) {
  *this = {};
  stated_period_ns_ = stated_period_ns;
}

void DriverGrade::evaluate(const FrameArrival& frame) {
  if (frame.damaged) {
    ++damaged_;
    return;
  }
  const bool any = frames_ > 0;
  const TimeNs before = any ? latest_.stamp_ns : frame.stamp_ns - 1;
  const std::uint32_t suspicion = suspicion_of_stamp(frame, before, stated_period_ns_);
  ahead_ += suspicion == finding::stamps_ahead ? 1 : 0;
  elsewhere_ += suspicion == finding::stamps_elsewhere ? 1 : 0;
  // A stamp may be wrong in two ways.
  stand_ += frame.stamp_ns <= before ? 1 : 0;
  if (any) {
    const std::uint32_t step = frame.sequence - latest_.sequence;
    const bool forward = step != 0 && step < 0x8000'0000U;
    sequence_stands_ += forward ? 0 : 1;
    missing_ += forward ? step - 1 : 0;
    changed_ = changed_ || frame.uniform || frame.sample_crc != latest_.sample_crc;
  } else {
    first_ = frame;
  }
  latest_ = frame;
  ++frames_;
}

bool DriverGrade::complete() const {
  if (frames_ >= frames_wanted || frames_ + damaged_ >= 2 * frames_wanted) return true;
  return frames_ >= least_frames && latest_.arrival_ns - first_.arrival_ns >= time_wanted_ns;
}

TimeNs DriverGrade::measured_period(const CameraVerdict& verdict) const {
  const TimeNs span =
      verdict.stamps_believed ? latest_.stamp_ns - first_.stamp_ns : latest_.arrival_ns - first_.arrival_ns;
  const std::int64_t intervals = frames_ - 1 + (verdict.sequence_believed ? missing_ : 0);
  return intervals > 0 ? span / intervals : 0;
}

CameraVerdict DriverGrade::verdict() const {
  CameraVerdict verdict;
  verdict.frames = frames_;
  verdict.missing = missing_;
  std::uint32_t findings = 0;
  if (habit(ahead_, frames_)) findings |= finding::stamps_ahead;
  if (habit(stand_, frames_)) findings |= finding::stamps_stand;
  if (habit(elsewhere_, frames_)) findings |= finding::stamps_elsewhere;
  verdict.stamps_believed = findings == 0;
  if (habit(sequence_stands_, frames_)) findings |= finding::sequence_stands;
  verdict.sequence_believed = (findings & finding::sequence_stands) == 0;
  if (verdict.sequence_believed && habit(missing_, frames_ + missing_)) findings |= finding::frames_missing;
  if (damaged_ > 0) findings |= finding::frames_damaged;
  if (!changed_) findings |= finding::frames_stuck;
  verdict.period_ns = measured_period(verdict);
  if (stated_period_ns_ > 0 && differs_by_a_tenth(verdict.period_ns, stated_period_ns_))
    findings |= finding::rate_differs;
  verdict.findings = findings;
  return verdict;
}

}  // namespace ilp
