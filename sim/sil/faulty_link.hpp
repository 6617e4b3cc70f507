// Wraps a link and injects outages.
#pragma once

#include "hal/clock/clock.hpp"
#include "hal/link/link.hpp"
#include "sim/sil/fault_plan.hpp"

namespace ilp::sil {

/// During an outage every call returns `not_ready`: nothing is sent, and no confirmation is received.
class FaultyLink final : public Link {
 public:
  FaultyLink(Link& link, Clock& clock, const FaultWindow& outage) : link_(link), clock_(clock), outage_(outage) {}

  Status begin_file(const char* name) override {
    if (contact()) return link_.begin_file(name);
    ++refused_;
    return StatusCode::not_ready;
  }
  Status write(std::span<const std::uint8_t> bytes) override {
    return contact() ? link_.write(bytes) : Status{StatusCode::not_ready};
  }
  Status end_file() override { return contact() ? link_.end_file() : Status{StatusCode::not_ready}; }
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override {
    return contact() ? link_.acknowledged(name, bytes, crc32) : Status{StatusCode::not_ready};
  }

  [[nodiscard]] bool contact() const { return !inside_window(clock_.now(), outage_); }
  /// Number of files that could not begin.
  [[nodiscard]] std::int64_t refused() const { return refused_; }

 private:
  Link& link_;
  Clock& clock_;
  FaultWindow outage_;
  std::int64_t refused_ = 0;
};

}  // namespace ilp::sil
