// A Compute for tests that acts as a slow device: it returns `waiting` a number of times, then the processor computes.
#pragma once

#include "hal/compute/cpu/cpu_compute.hpp"

namespace ilp::test {

class LateCompute final : public Compute {
 public:
  explicit LateCompute(const ComputeForms& forms, int waits) : cpu_(forms), waits_(waits) {}
  Status submit(const ComputeJob& job) override {
    left_ = waits_;
    ++jobs_;
    return cpu_.submit(job);
  }
  ComputeProgress ask(ComputeKind kind) override { return left_-- > 0 ? ComputeProgress::waiting : cpu_.ask(kind); }
  void drop(ComputeKind kind) override { cpu_.drop(kind); }
  [[nodiscard]] bool on_device() const override { return true; }
  [[nodiscard]] int jobs() const { return jobs_; }

 private:
  CpuCompute cpu_;
  int waits_, left_ = 0, jobs_ = 0;
};

}  // namespace ilp::test
