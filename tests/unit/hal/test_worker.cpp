// A worker gives the same result whenever it runs a job, and is never waited for in flight.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "fsw/base/rng.hpp"
#include "hal/posix/measured_stack.hpp"
#include "hal/worker/inline_worker.hpp"
#include "hal/worker/thread_worker.hpp"

namespace ilp {
namespace {

// Sanitizers keep a megabyte of their own in each stack.
constexpr std::size_t stack_bytes = std::size_t{2} << 20U;
constexpr std::size_t stacks = 8;
alignas(stack_page_bytes) std::byte stack_memory[stacks][stack_bytes];
std::size_t stacks_used = 0;
std::span<std::byte> new_stack() {
  return stack_memory[stacks_used++];
}

/// Plain memory that a job reads and writes: a sanitizer of threads sees whether it is handed over.
struct Sum {
  std::array<std::uint64_t, 64> numbers{};

  static void run(void* memory) {
    for (std::uint64_t& number : static_cast<Sum*>(memory)->numbers) number = mix64(number + 1);
  }
};

/// A job that goes on until it is let go.
struct Endless {
  std::atomic<bool> begun{false};
  std::atomic<bool> free{false};

  static void run(void* memory) {
    auto& self = *static_cast<Endless*>(memory);
    self.begun = true;
    while (!self.free) {
    }
  }
};

void pause() {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
}
WorkerProgress ask_until_it_changes(Worker& worker) {
  WorkerProgress progress = worker.ask();
  for (; progress == WorkerProgress::working; progress = worker.ask()) pause();
  return progress;
}

TEST(Worker, EveryJobLeavesTheSameBytesInAThreadAndInline) {
  ThreadWorker beside;
  ASSERT_EQ(beside.start(new_stack()), 0);
  InlineWorker here;
  Sum in_thread, in_line;
  for (int job = 0; job < 500; ++job) {
    in_thread.numbers[0] = in_line.numbers[0] = static_cast<std::uint64_t>(job);
    ASSERT_TRUE(beside.submit({Sum::run, &in_thread}).ok());
    ASSERT_TRUE(here.submit({Sum::run, &in_line}).ok());
    ASSERT_EQ(ask_until_it_changes(beside), WorkerProgress::done);
    ASSERT_EQ(here.ask(), WorkerProgress::done);
    ASSERT_EQ(in_thread.numbers, in_line.numbers);
  }
  EXPECT_TRUE(beside.stop());
  EXPECT_EQ(beside.stats().jobs, 500U);
}

void expect_one_job_at_a_time(Worker& worker) {
  Sum first, second;
  EXPECT_EQ(worker.ask(), WorkerProgress::idle);
  EXPECT_TRUE(worker.submit({Sum::run, &first}).ok());
  EXPECT_TRUE(worker.submit({Sum::run, &second}).is(StatusCode::not_ready));
  worker.finish();
  EXPECT_TRUE(worker.submit({Sum::run, &second}).is(StatusCode::not_ready)) << "nobody was told of the first one";
  EXPECT_EQ(worker.ask(), WorkerProgress::done);
  EXPECT_EQ(worker.ask(), WorkerProgress::idle);
  EXPECT_NE(first.numbers[0], 0U);
  EXPECT_EQ(second.numbers[0], 0U);
}

TEST(Worker, HasOneJobUntilItsEndWasTold) {
  InlineWorker here;
  expect_one_job_at_a_time(here);
  ThreadWorker beside;
  Sum none;
  EXPECT_TRUE(beside.submit({Sum::run, &none}).is(StatusCode::not_ready)) << "there is no thread yet";
  ASSERT_EQ(beside.start(new_stack()), 0);
  expect_one_job_at_a_time(beside);
  EXPECT_TRUE(beside.stop());
  EXPECT_TRUE(beside.submit({Sum::run, &none}).is(StatusCode::not_ready)) << "there is no thread any more";
}

TEST(Worker, NobodyWaitsForAJobInAThread) {
  ThreadWorker worker;
  ASSERT_EQ(worker.start(new_stack()), 0);
  Endless job;
  ASSERT_TRUE(worker.submit({Endless::run, &job}).ok());
  EXPECT_EQ(worker.ask(), WorkerProgress::working);
  while (!job.begun) pause();
  EXPECT_EQ(worker.ask(), WorkerProgress::working);
  job.free = true;
  EXPECT_EQ(ask_until_it_changes(worker), WorkerProgress::done);
  EXPECT_TRUE(worker.stop());
}

TEST(Worker, WhereTimeStandsStillTheFirstQuestionIsAnswered) {
  ThreadWorker worker;
  ASSERT_EQ(worker.start(new_stack()), 0);
  worker.wait_for_answers();
  Sum sum;
  for (int job = 0; job < 100; ++job) {
    ASSERT_TRUE(worker.submit({Sum::run, &sum}).ok());
    ASSERT_EQ(worker.ask(), WorkerProgress::done);
  }
  EXPECT_TRUE(worker.stop());
}

/// Where a job runs.
struct Place {
  int nice = 0;
  std::uintptr_t address = 0;

  static void run(void* memory) {
    auto& self = *static_cast<Place*>(memory);
    self.nice = getpriority(PRIO_PROCESS, 0);
    std::array<volatile std::byte, 20'000> used{};
    self.address = reinterpret_cast<std::uintptr_t>(used.data());
  }
};

TEST(Worker, TheThreadHasItsOwnStackAndALowerPriority) {
  const std::span<std::byte> stack = new_stack();
  ThreadWorker worker;
  ASSERT_EQ(worker.start(stack), 0);
  worker.wait_for_answers();
  Place place;
  ASSERT_TRUE(worker.submit({Place::run, &place}).ok());
  ASSERT_EQ(worker.ask(), WorkerProgress::done);
  EXPECT_TRUE(worker.stop());
  const auto begin = reinterpret_cast<std::uintptr_t>(stack.data());
  EXPECT_GE(place.address, begin + stack_page_bytes);
  EXPECT_LT(place.address, begin + stack.size());
  EXPECT_GE(stack_peak(stack), 20'000U);
  EXPECT_LT(stack_peak(stack), usable_stack(stack).size());
  EXPECT_GT(place.nice, getpriority(PRIO_PROCESS, 0));
}

TEST(Worker, AJobThatNeverEndsIsStuckAfterItsProcessorTime) {
  const auto worker = std::make_unique<ThreadWorker>(20 * ns_per_ms);
  ASSERT_EQ(worker->start(new_stack()), 0);
  Endless job;
  Sum sum;
  ASSERT_TRUE(worker->submit({Endless::run, &job}).ok());
  EXPECT_EQ(ask_until_it_changes(*worker), WorkerProgress::stuck);
  EXPECT_EQ(worker->ask(), WorkerProgress::stuck);
  EXPECT_TRUE(worker->submit({Sum::run, &sum}).is(StatusCode::not_ready));
  worker->finish();
  EXPECT_FALSE(worker->stop()) << "a thread cannot be ended from outside";
  // If it ends after all, the worker is as before.
  job.free = true;
  WorkerProgress progress = worker->ask();
  for (; progress == WorkerProgress::stuck; progress = worker->ask()) pause();
  EXPECT_EQ(progress, WorkerProgress::done);
  ASSERT_TRUE(worker->submit({Sum::run, &sum}).ok());
  EXPECT_EQ(ask_until_it_changes(*worker), WorkerProgress::done);
  EXPECT_TRUE(worker->stop());
}

}  // namespace
}  // namespace ilp
