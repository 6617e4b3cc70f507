#include "hal/compute/guarded_compute.hpp"

#include <cstring>

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t examples = 2;

}  // namespace

ComputeFault GuardedCompute::check_unit(ComputeKind kind, std::size_t unit, std::span<const std::byte> input,
                                        std::span<const std::byte> output) {
  const std::size_t bytes = cpu_.form(kind).unit_bytes;
  if (bytes > unit_.size()) return ComputeFault::wrong;
  cpu_.compute(kind, input, unit, std::span(unit_).first(bytes));
  return std::memcmp(unit_.data(), output.data() + unit * bytes, bytes) == 0 ? ComputeFault::none : ComputeFault::wrong;
}

ComputeFault GuardedCompute::compare(ComputeDevice& device, ComputeKind kind, std::span<std::byte> input,
                                     std::span<std::byte> output) {
  const ComputeForm& form = cpu_.form(kind);
  for (std::uint32_t number = 0; number < examples; ++number) {
    form.example(form.workspace, number, input);
    ComputeFault fault = device.begin({kind, input, output});
    bool done = false;
    while (fault == ComputeFault::none && !done) {  // bound: the limit of time, after which the device is late
      device.pause();
      fault = device.ask(kind, done);
    }
    for (std::size_t unit = 0; fault == ComputeFault::none && unit < form.units; ++unit) {
      fault = check_unit(kind, unit, input, output);
    }
    if (fault != ComputeFault::none) return fault;
  }
  return ComputeFault::none;
}

Status GuardedCompute::accept(ComputeDevice& device, std::span<std::byte> inputs, std::span<std::byte> outputs) {
  for (std::size_t k = 0; k < compute_kinds; ++k) {
    const auto kind = static_cast<ComputeKind>(k);
    const ComputeForm& form = cpu_.form(kind);
    const bool fits = inputs.size() >= form.input_bytes && outputs.size() >= form.output_bytes();
    const ComputeFault fault =
        fits ? compare(device, kind, inputs.first(form.input_bytes), outputs.first(form.output_bytes()))
             : ComputeFault::unreachable;
    if (fault == ComputeFault::none) continue;
    device.leave();
    return updates_ = {StatusCode::compute_refused, static_cast<std::int64_t>(fault), static_cast<std::int64_t>(k)};
  }
  device_ = &device;
  updates_ = {StatusCode::compute_ready, static_cast<std::int64_t>(compute_kinds)};
  return {};
}

void GuardedCompute::abandon(ComputeKind kind, ComputeFault fault) {
  updates_ = {StatusCode::compute_lost, static_cast<std::int64_t>(fault), static_cast<std::int64_t>(kind)};
  device_->leave();
  device_ = nullptr;
  for (Place& place : places_) {
    // It was accepted once, so it is accepted again.
    if (place.on_device) static_cast<void>(cpu_.submit(place.job));
    place.on_device = false;
  }
}

Status GuardedCompute::submit(const ComputeJob& job) {
  ILP_TRY(cpu_.check(job));
  if (device_ == nullptr) return cpu_.submit(job);
  places_[static_cast<std::size_t>(job.kind)] = {job, true};
  const ComputeFault fault = device_->begin(job);
  if (fault != ComputeFault::none) abandon(job.kind, fault);
  return {};
}

ComputeProgress GuardedCompute::ask_device(ComputeKind kind) {
  Place& place = places_[static_cast<std::size_t>(kind)];
  bool done = false;
  ComputeFault fault = device_->ask(kind, done);
  // bound: the limit of time, after which the device is late
  while (patient_ && fault == ComputeFault::none && !done) {
    device_->pause();
    fault = device_->ask(kind, done);
  }
  if (fault == ComputeFault::none && !done) return ComputeProgress::waiting;
  if (fault == ComputeFault::none) {
    const ComputeForm& form = cpu_.form(kind);
    const auto unit = static_cast<std::size_t>(mix64(++checks_) % form.units);
    fault = check_unit(kind, unit, place.job.input, place.job.output);
  }
  if (fault != ComputeFault::none) {
    abandon(kind, fault);
    return ComputeProgress::working;
  }
  place.on_device = false;
  return ComputeProgress::done;
}

ComputeProgress GuardedCompute::ask(ComputeKind kind) {
  if (places_[static_cast<std::size_t>(kind)].on_device) return ask_device(kind);
  return cpu_.ask(kind);
}

void GuardedCompute::drop(ComputeKind kind) {
  places_[static_cast<std::size_t>(kind)].on_device = false;
  cpu_.drop(kind);
}

Status GuardedCompute::take_updates() {
  const Status updates = updates_;
  updates_ = {};
  return updates;
}

}  // namespace ilp
