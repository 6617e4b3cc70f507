// The wide search on a Vulkan device: Mesa's lavapipe, which computes on the processor. Their bytes
// are those of the processor's functions, on made-up ground and on recorded images, and a flight goes on when the
// program ends or hangs.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "bsp/flight/flight_compute.hpp"
#include "fsw/base/checksum.hpp"
#include "hal/compute/shared/shared_compute.hpp"
#include "tests/support/strip.hpp"
#include "tests/vulkan/vulkan_program.hpp"

namespace ilp {
namespace {

constexpr TimeNs long_limit = 300 * ns_per_s;

struct Flight {
  FlightCompute jobs;
  SharedCompute device{jobs.forms()};
  WideWorkspace workspace{};
  WideInput input{};
  WideOutput output{};
  WideJob spare;

  Status begin(const test::VulkanProgram& program) {
    static_cast<void>(device.open({program.socket(), long_limit}));
    return jobs.accept(device, spare);
  }
  void submit() {
    ASSERT_TRUE(jobs.compute()
                    .submit({ComputeKind::wide_search, memory_of(input), std::as_writable_bytes(std::span(&output, 1))})
                    .ok());
  }
  void finish() {
    ComputeProgress progress = ComputeProgress::working;
    while (progress != ComputeProgress::done) {
      progress = jobs.compute().ask(ComputeKind::wide_search);
      if (progress == ComputeProgress::waiting) device.pause();
    }
  }
  /// How many shifts have a score; -1 where a byte differs from the processor's.
  int scores_if_equal() {
    int scores = 0;
    for (std::size_t pose = 0; pose < wide_job_poses; ++pose) {
      std::array<std::uint32_t, wide_max_shifts> best;
      search_wide_pose(input, pose, workspace, best);
      if (best != output.best[pose]) return -1;
      for (const std::uint32_t word : best) scores += word != 0 ? 1 : 0;
    }
    return scores;
  }
};

/// Some frames of a recorded strip; none where there are no data.
std::vector<test::Image> recorded_frames() {
  constexpr std::size_t wanted = 6;
  const char* const folder = "aerial_caliterra_a";
  std::vector<test::Image> frames;
  for (const test::StripImage& image : test::read_strip(folder)) {
    if (frames.size() < wanted) frames.push_back(test::read_strip_image(folder, image.name));
  }
  return frames;
}

class VulkanCompute : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(flight_->begin(program_).ok()); }

  test::VulkanProgram program_;
  std::unique_ptr<Flight> flight_ = std::make_unique<Flight>();
};

TEST_F(VulkanCompute, MadeUpJobsHaveTheProcessorsBytes) {
  int scores = 0;
  for (std::uint32_t number = 100; number < 130; ++number) {
    make_wide_example(number, flight_->input);
    flight_->output = {};
    flight_->submit();
    flight_->finish();
    ASSERT_TRUE(flight_->jobs.compute().on_device());
    const int equal = flight_->scores_if_equal();
    ASSERT_GE(equal, 0) << number;
    scores += equal;
  }
  EXPECT_GT(scores, 10000);
}

TEST_F(VulkanCompute, JobsOfRecordedPairsHaveTheProcessorsBytes) {
  const std::vector<test::Image> frames = recorded_frames();
  if (frames.empty()) GTEST_SKIP() << "no recorded data beside the checkout";
  const auto first = std::make_unique<Pyramid>(), second = std::make_unique<Pyramid>();
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    ASSERT_TRUE(first->build(frames[i].view(), coarse_max_side).ok());
    ASSERT_TRUE(second->build(frames[i + 1].view(), coarse_max_side).ok());
    const int level = wide_search_level(*first);
    WidePlan plan;
    ASSERT_TRUE(prepare_wide_search(first->level(level), second->level(level), 0.5, flight_->input, plan).ok());
    for (std::int32_t job = static_cast<std::int32_t>(i) * 5; job < plan.jobs(); job += 30) {
      fill_wide_job(plan, job, flight_->input);
      flight_->submit();
      flight_->finish();
      ASSERT_TRUE(flight_->jobs.compute().on_device());
      ASSERT_GT(flight_->scores_if_equal(), 0) << i << " " << job;
    }
  }
}

TEST_F(VulkanCompute, AProgramThatIsKilledInAJobCostsAnEvent) {
  make_wide_example(6, flight_->input);
  flight_->submit();
  program_.send(SIGKILL);
  flight_->finish();
  EXPECT_GT(flight_->scores_if_equal(), 0);
  const Status updates = flight_->jobs.compute().take_updates();
  EXPECT_TRUE(updates.is(StatusCode::compute_lost));
  EXPECT_EQ(updates.a, static_cast<std::int64_t>(ComputeFault::gone));
}

TEST_F(VulkanCompute, AProgramThatHangsIsLate) {
  make_wide_example(8, flight_->input);
  flight_->device.limit(100 * ns_per_ms);
  program_.send(SIGSTOP);
  flight_->submit();
  flight_->finish();
  EXPECT_GT(flight_->scores_if_equal(), 0);
  const Status updates = flight_->jobs.compute().take_updates();
  EXPECT_TRUE(updates.is(StatusCode::compute_lost));
  EXPECT_EQ(updates.a, static_cast<std::int64_t>(ComputeFault::late));
}

}  // namespace
}  // namespace ilp
