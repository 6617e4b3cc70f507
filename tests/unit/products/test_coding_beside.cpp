// Products that a worker codes are those of the steps, whenever it is done, and whatever happens meanwhile.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "hal/posix/measured_stack.hpp"
#include "hal/worker/thread_worker.hpp"
#include "tests/unit/products/compressor_fixture.hpp"
#include "tests/unit/shared/executed_component.hpp"

namespace ilp {
namespace {

/// Does the job when it is asked for the n-th time, or never.
class SlowWorker final : public Worker {
 public:
  explicit SlowWorker(int asks) : asks_(asks) {}

  Status submit(const WorkerJob& job) override {
    if (left_ >= 0) return StatusCode::not_ready;
    job_ = job;
    left_ = asks_;
    ++submitted;
    return {};
  }
  WorkerProgress ask() override {
    if (left_ < 0) return WorkerProgress::idle;
    if (is_stuck) return WorkerProgress::stuck;
    if (--left_ >= 0) return WorkerProgress::working;
    job_.run(job_.memory);
    return WorkerProgress::done;
  }
  void finish() override {}

  int submitted = 0;
  bool is_stuck = false;

 private:
  int asks_;
  int left_ = -1;
  WorkerJob job_;
};

class CodingBeside : public test::CompressorTest {
 protected:
  static constexpr std::int64_t keyframes = 3;
  using Products = std::vector<std::vector<std::uint8_t>>;

  void SetUp() override {
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      write_keyframe(id, 0.3 + 0.1 * static_cast<double>(id), id == 2 ? 0.05 : 0.3, id * ns_per_s);
    }
    compress();
    wanted_ = test::all_of<ProductRecord>(store);
    ASSERT_EQ(wanted_.size(), 2U * keyframes);
    begin_again();
  }
  /// As if no product had been made.
  void begin_again() { test::erase_records<ProductRecord, CheckpointRecord>(store); }
  std::unique_ptr<Compressor> begin(Worker& worker) {
    auto compressor = std::make_unique<Compressor>(store, mission, test::step_memory<Compressor>(), &worker);
    EXPECT_TRUE(compressor->restore().ok());
    return compressor;
  }
  /// Steps until others may use the memory of a step.
  static StepResult next_step(Compressor& compressor) {
    StepResult result = compressor.step();
    while (result.then == Then::keep) result = compressor.step();
    return result;
  }
  /// Steps until nothing is left to do. Between two steps others use the memory of a step.
  void fly(Compressor& compressor) {
    for (bool pending = true; pending;) {
      const StepResult result = next_step(compressor);
      ASSERT_TRUE(result.status.ok()) << status_name(result.status.code);
      pending = result.pending;
      if (result.then == Then::wait) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      test::step_memory<Compressor>().bytes.fill(std::byte{0x5A});
    }
  }
  void expect_products() { EXPECT_EQ(test::all_of<ProductRecord>(store), wanted_); }

  Products wanted_;
};

TEST_F(CodingBeside, WheneverTheWorkerIsDoneTheProductsAreTheSame) {
  for (const int asks : {0, 1, 2, 7}) {
    begin_again();
    SlowWorker worker(asks);
    fly(*begin(worker));
    expect_products();
    EXPECT_EQ(worker.submitted, 2 * keyframes);
  }
}

// Sanitizers keep a megabyte of their own in it.
alignas(stack_page_bytes) std::byte stack[std::size_t{2} << 20U];

TEST_F(CodingBeside, InAThreadTheProductsAreTheSame) {
  ThreadWorker worker;
  ASSERT_EQ(worker.start(stack), 0);
  const auto compressor = begin(worker);
  fly(*compressor);
  expect_products();
  EXPECT_TRUE(worker.stop());
  EXPECT_EQ(worker.stats().jobs, 2U * keyframes);
}

TEST_F(CodingBeside, WhileAJobRunsTheStepWaitsForTheNextMinorFrame) {
  SlowWorker worker(2);
  const auto compressor = begin(worker);
  for (int i = 0; i < 2; ++i) {
    const StepResult result = next_step(*compressor);
    EXPECT_TRUE(result.pending);
    EXPECT_EQ(result.then, Then::wait);
    EXPECT_TRUE(test::all_of<ProductRecord>(store).empty());
  }
  EXPECT_EQ(next_step(*compressor).then, Then::go_on);
  EXPECT_EQ(test::all_of<ProductRecord>(store).size(), 1U);
}

TEST_F(CodingBeside, ARestoreInTheMiddleOfAJobMakesTheSameProducts) {
  SlowWorker worker(3);
  const auto compressor = begin(worker);
  for (int i = 0; i < 5; ++i) static_cast<void>(next_step(*compressor));
  ASSERT_TRUE(compressor->restore().ok());
  fly(*compressor);
  expect_products();
  EXPECT_EQ(worker.submitted, 2 * keyframes + 1) << "the job is handed over again when the worker has ended it";
}

// A component whose flags were damaged is like a new one at a worker that has a job.
TEST_F(CodingBeside, AfterARestoreTheWorkerIsAskedFirstWhateverTheMemoryOfTheComponentSays) {
  SlowWorker worker(4);
  const auto before = begin(worker);
  static_cast<void>(next_step(*before));
  const auto compressor = begin(worker);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(next_step(*compressor).then, Then::wait);
    ASSERT_TRUE(compressor->restore().ok());
    EXPECT_EQ(worker.submitted, 1) << "the memory of the job is still the worker's";
  }
  fly(*compressor);
  expect_products();
  EXPECT_EQ(worker.submitted, 2 * keyframes + 1);
}

TEST_F(CodingBeside, AProcessThatEndsInTheMiddleOfAJobMakesTheSameProductsAfterItsNextStart) {
  for (int steps = 1; steps < 12; ++steps) {
    begin_again();
    {
      SlowWorker worker(2);
      const auto compressor = begin(worker);
      for (int i = 0; i < steps; ++i) static_cast<void>(compressor->step());
    }
    SlowWorker worker(1);
    fly(*begin(worker));
    expect_products();
  }
}

TEST_F(CodingBeside, ParametersThatChangeMeanwhileActOnTheNextProduct) {
  SlowWorker worker(1);
  const auto compressor = begin(worker);
  static_cast<void>(next_step(*compressor));
  mission.depth_error_px = 3;
  mission.region_coding = !mission.region_coding;
  static_cast<void>(next_step(*compressor));
  const Products made = test::all_of<ProductRecord>(store);
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0], wanted_[0]);
  fly(*compressor);
  EXPECT_NE(test::all_of<ProductRecord>(store)[1], wanted_[1]);
}

TEST_F(CodingBeside, InSafeModeTheResultWaits) {
  SlowWorker worker(1);
  const auto compressor = begin(worker);
  static_cast<void>(next_step(*compressor));
  mission.safe_mode = true;
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(next_step(*compressor).pending);
  EXPECT_TRUE(test::all_of<ProductRecord>(store).empty());
  mission.safe_mode = false;
  fly(*compressor);
  expect_products();
  EXPECT_EQ(worker.submitted, 2 * keyframes);
}

TEST_F(CodingBeside, AJobThatIsStuckCostsItsProductAndANewStart) {
  SlowWorker worker(1);
  const auto compressor = begin(worker);
  static_cast<void>(next_step(*compressor));
  static_cast<void>(next_step(*compressor));
  ASSERT_EQ(test::all_of<ProductRecord>(store).size(), 1U);
  static_cast<void>(next_step(*compressor));
  EXPECT_FALSE(compressor->worker_stuck());
  worker.is_stuck = true;
  const std::int64_t lost = product_id(1, ProductKind::image);
  const StepResult result = next_step(*compressor);
  EXPECT_TRUE(result.status.is(StatusCode::worker_stuck));
  EXPECT_EQ(result.status.a, lost);
  EXPECT_TRUE(compressor->worker_stuck());
  EXPECT_EQ(read<ProductRecord>(lost).state, ProductState::dropped);
  EXPECT_EQ(read<ProductRecord>(lost).data.bytes, 0U);
  const StepResult after = next_step(*compressor);
  EXPECT_TRUE(after.status.ok()) << "it is told once";
  EXPECT_FALSE(after.pending);
  // The new process does not meet the same job again.
  SlowWorker new_worker(1);
  fly(*begin(new_worker));
  EXPECT_EQ(new_worker.submitted, 2 * keyframes - 2);
  const Products made = test::all_of<ProductRecord>(store);
  ASSERT_EQ(made.size(), wanted_.size());
  for (std::size_t i = 0; i < made.size(); ++i) EXPECT_EQ(made[i] == wanted_[i], i != 1) << i;
}

}  // namespace
}  // namespace ilp
