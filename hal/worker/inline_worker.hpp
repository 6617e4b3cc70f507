// A worker whose submit() runs the job. For virtual time, for processes without a primary, and for tests.
#pragma once

#include "hal/worker/worker.hpp"

namespace ilp {

class InlineWorker final : public Worker {
 public:
  Status submit(const WorkerJob& job) override {
    if (has_job_) return StatusCode::not_ready;
    job.run(job.memory);
    has_job_ = true;
    return {};
  }
  WorkerProgress ask() override {
    const bool done = has_job_;
    has_job_ = false;
    return done ? WorkerProgress::done : WorkerProgress::idle;
  }
  void finish() override {}

 private:
  bool has_job_ = false;
};

}  // namespace ilp
