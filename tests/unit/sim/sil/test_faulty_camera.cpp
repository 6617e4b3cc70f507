#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "sim/sil/faulty_camera.hpp"

namespace ilp::sil {
namespace {

constexpr TimeNs interval_ns = 2 * ns_per_s;

/// Frame n of `frames` is taken at 2 (n - 1) s; every pixel of its image has a value that identifies n.
class CountingCamera final : public Camera {
 public:
  explicit CountingCamera(std::int64_t frames) : frames_(frames) {}
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    if (next_ > frames_) return StatusCode::end_of_stream;
    if (interval_ns * (next_ - 1) > now) return StatusCode::not_ready;
    frame = {};
    frame.sequence = next_;
    frame.time_ns = interval_ns * (next_ - 1);
    static_cast<void>(image.resize(8, 6));
    std::fill_n(image.view().data, image.view().area(), value_of(next_));
    ++next_;
    return {};
  }
  static std::uint8_t value_of(std::int64_t sequence) { return static_cast<std::uint8_t>(50 + sequence % 100); }

 private:
  std::int64_t frames_;
  std::int64_t next_ = 1;
};

struct Delivered {
  std::int64_t sequence;
  TimeNs time_ns;
  TimeNs at_ns;
  std::uint8_t value;
  bool operator==(const Delivered&) const = default;
};

struct Outcome {
  std::vector<Delivered> frames;
  CameraFaultCounts counts;

  [[nodiscard]] std::int64_t with_value(int value) const {
    return std::count_if(frames.begin(), frames.end(), [value](const Delivered& f) { return f.value == value; });
  }
};

/// Asks every `period` until the camera ends.
Outcome watch(const FaultPlan& plan, std::int64_t frames = 400, TimeNs period = ns_per_s / 2, std::uint64_t seed = 7) {
  CountingCamera source(frames);
  FaultyCamera camera(source, plan, seed);
  const auto image = std::make_unique<FrameImage>();
  Outcome outcome;
  for (TimeNs now = 0; now < interval_ns * frames + 1000 * ns_per_s;) {
    CameraFrame frame;
    const Status status = camera.capture(now, *image, frame);
    if (status.is(StatusCode::end_of_stream)) {
      outcome.counts = camera.counts();
      return outcome;
    }
    if (status.ok()) {
      outcome.frames.push_back({frame.sequence, frame.time_ns, now, image->view().at(3, 2)});
    } else {
      now += period;
    }
  }
  ADD_FAILURE() << "the camera never ends";
  return outcome;
}

std::set<std::int64_t> sequences(const Outcome& outcome) {
  std::set<std::int64_t> found;
  for (const Delivered& frame : outcome.frames) found.insert(frame.sequence);
  return found;
}

TEST(FaultyCamera, WithoutFaultsEveryFrameComesOnceInTimeAndUnchanged) {
  const Outcome outcome = watch({});
  ASSERT_EQ(outcome.frames.size(), 400U);
  for (std::int64_t n = 1; n <= 400; ++n) {
    const TimeNs time = interval_ns * (n - 1);
    EXPECT_EQ(outcome.frames[static_cast<std::size_t>(n - 1)], (Delivered{n, time, time, CountingCamera::value_of(n)}));
  }
}

TEST(FaultyCamera, AboutTheAskedShareIsLostAndCounted) {
  FaultPlan plan{.lost_share = 0.25};
  const Outcome outcome = watch(plan);
  EXPECT_EQ(static_cast<std::int64_t>(outcome.frames.size()), 400 - outcome.counts.lost);
  // Four standard deviations of 400 draws.
  EXPECT_NEAR(static_cast<double>(outcome.counts.lost), 100, 35);
}

TEST(FaultyCamera, ADuplicateIsTheSameFrameOnceMore) {
  FaultPlan plan{.duplicated_share = 0.2};
  const Outcome outcome = watch(plan);
  EXPECT_GT(outcome.counts.duplicated, 40);
  ASSERT_EQ(static_cast<std::int64_t>(outcome.frames.size()), 400 + outcome.counts.duplicated);
  std::int64_t twins = 0;
  for (std::size_t i = 1; i < outcome.frames.size(); ++i) {
    if (outcome.frames[i].sequence == outcome.frames[i - 1].sequence) {
      EXPECT_EQ(outcome.frames[i], outcome.frames[i - 1]);
      ++twins;
    }
  }
  EXPECT_EQ(twins, outcome.counts.duplicated);
}

TEST(FaultyCamera, ALateFrameIsOvertakenAndComesAllTheSame) {
  FaultPlan plan{.late_share = 0.1, .late_by_s = 5};
  const Outcome outcome = watch(plan);
  EXPECT_GT(outcome.counts.late, 15);
  EXPECT_EQ(sequences(outcome).size(), 400U);
  std::int64_t late = 0;
  for (const Delivered& frame : outcome.frames) {
    EXPECT_EQ(frame.value, CountingCamera::value_of(frame.sequence));
    if (frame.at_ns == frame.time_ns) continue;
    EXPECT_EQ(frame.at_ns - frame.time_ns, 5 * ns_per_s);
    ++late;
  }
  EXPECT_EQ(late, outcome.counts.late);
}

TEST(FaultyCamera, TheLastFrameMayBeLate) {
  FaultPlan plan{.late_share = 1, .late_by_s = 100};
  EXPECT_EQ(watch(plan, 5).frames.size(), 5U);
}

TEST(FaultyCamera, AWrongStampIsOffByWhatWasAskedForAndTheFrameComesInTime) {
  for (const double by_s : {60.0, -60.0}) {
    FaultPlan plan{.misstamped_share = 0.1, .misstamped_by_s = by_s};
    const Outcome outcome = watch(plan);
    std::int64_t wrong = 0;
    for (const Delivered& frame : outcome.frames) {
      const TimeNs error = frame.time_ns - interval_ns * (frame.sequence - 1);
      EXPECT_EQ(frame.at_ns, interval_ns * (frame.sequence - 1));
      if (error == 0) continue;
      EXPECT_EQ(error, static_cast<TimeNs>(by_s) * ns_per_s);
      ++wrong;
    }
    EXPECT_GT(wrong, 15);
    EXPECT_EQ(wrong, outcome.counts.misstamped);
  }
}

TEST(FaultyCamera, BlackAndWhiteImagesAreWhatTheCountsSay) {
  FaultPlan plan{.black_share = 0.1, .saturated_share = 0.1};
  const Outcome outcome = watch(plan);
  EXPECT_GT(outcome.counts.black, 15);
  EXPECT_GT(outcome.counts.saturated, 15);
  EXPECT_EQ(outcome.with_value(0), outcome.counts.black);
  EXPECT_EQ(outcome.with_value(255), outcome.counts.saturated);
}

TEST(FaultyCamera, WhileItIsDeadNothingComes) {
  FaultPlan plan{.dead_from_s = 100, .dead_for_s = 20};
  EXPECT_EQ(watch(plan).counts.dead, 10);
  plan.dead_every_s = 200;  // 100-120, 300-320, 500-520, 700-720 of 800 s
  const Outcome outcome = watch(plan);
  EXPECT_EQ(outcome.counts.dead, 40);
  for (const Delivered& frame : outcome.frames) {
    const TimeNs phase = frame.time_ns % (200 * ns_per_s);
    EXPECT_FALSE(phase >= 100 * ns_per_s && phase < 120 * ns_per_s) << frame.sequence;
  }
}

TEST(FaultyCamera, WhichFramesAreHitDoesNotDependOnHowOftenItIsAskedOrOnOtherFaults) {
  FaultPlan plan{.lost_share = 0.2};
  EXPECT_EQ(sequences(watch(plan)), sequences(watch(plan, 400, 60 * ns_per_s)));
  const std::set<std::int64_t> alone = sequences(watch(plan));
  plan.black_share = 0.3;
  plan.duplicated_share = 0.3;
  EXPECT_EQ(sequences(watch(plan)), alone);
  EXPECT_NE(sequences(watch(plan, 400, ns_per_s, 8)), alone) << "another seed hits others";
}

TEST(FaultyCamera, BlurIsTheMeanOfASquareTwice) {
  constexpr int width = 17;
  constexpr int height = 11;
  constexpr int radius = 2;
  std::vector<std::uint8_t> pixels(width * height);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * 7919 % 251);
  std::vector<double> expected(pixels.begin(), pixels.end());
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<double> before = expected;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (int dy = -radius; dy <= radius; ++dy) {
          for (int dx = -radius; dx <= radius; ++dx) {
            const int u = std::clamp(x + dx, 0, width - 1);
            const int v = std::clamp(y + dy, 0, height - 1);
            sum += before[static_cast<std::size_t>(v * width + u)];
          }
        }
        expected[static_cast<std::size_t>(y * width + x)] = sum / ((2 * radius + 1) * (2 * radius + 1));
      }
    }
  }
  blur({pixels.data(), width, height}, radius);
  // Four times rounded to whole grey levels.
  for (std::size_t i = 0; i < pixels.size(); ++i) EXPECT_NEAR(pixels[i], expected[i], 2.0) << i;
}

}  // namespace
}  // namespace ilp::sil
