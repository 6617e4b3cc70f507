// A stand-in for nonvolatile memory in tests and flights in virtual time. Its content is lost with the object.
#pragma once

#include <algorithm>
#include <array>

#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

class RamNonvolatile final : public Nonvolatile {
 public:
  Status read(std::span<std::uint8_t> content, std::size_t& bytes) override {
    bytes = 0;
    if (bytes_ == 0) return StatusCode::not_found;
    if (bytes_ > content.size()) return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(bytes_)};
    std::copy_n(content_.begin(), bytes_, content.begin());
    bytes = bytes_;
    return {};
  }
  Status write(std::span<const std::uint8_t> content) override {
    if (content.size() > content_.size()) {
      return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(content.size()), max_nonvolatile_bytes};
    }
    std::copy(content.begin(), content.end(), content_.begin());
    bytes_ = content.size();
    return {};
  }

 private:
  std::array<std::uint8_t, max_nonvolatile_bytes> content_{};
  std::size_t bytes_ = 0;
};

}  // namespace ilp
