// A link in memory.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fsw/base/crc.hpp"
#include "hal/link/link.hpp"

namespace ilp::test {

using Bytes = std::vector<std::uint8_t>;

/// Remembers whole files in the order in which they became visible; the test speaks for the ground.
class FakeLink final : public Link {
 public:
  Status begin_file(const char* name) override {
    if (!contact) return StatusCode::not_ready;
    open_name_ = name;
    open_.clear();
    return {};
  }
  Status write(std::span<const std::uint8_t> bytes) override {
    if (disk_full) return {StatusCode::io_error, 28};
    if (writes_until_fault == 0) {
      writes_until_fault = -1;
      return {StatusCode::io_error, 28};
    }
    if (writes_until_fault > 0) --writes_until_fault;
    open_.insert(open_.end(), bytes.begin(), bytes.end());
    return {};
  }
  Status end_file() override {
    if (!contact) return StatusCode::not_ready;
    order.push_back(open_name_);
    files[open_name_] = open_;
    total_bytes += open_.size();
    return {};
  }
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc) override {
    const auto found = confirmed.find(name);
    if (found == confirmed.end()) return StatusCode::not_ready;
    bytes = found->second.first;
    crc = found->second.second;
    return {};
  }
  Status unsent(std::int64_t& bytes) override {
    bytes = unsent_bytes;
    return {};
  }
  void confirm(const std::string& name) {
    confirmed[name] = {static_cast<std::uint32_t>(files[name].size()), crc32(files[name])};
  }

  std::vector<std::string> order;
  std::map<std::string, Bytes> files;
  std::map<std::string, std::pair<std::uint32_t, std::uint32_t>> confirmed;
  std::size_t total_bytes = 0;
  std::int64_t unsent_bytes = 0;
  int writes_until_fault = -1;
  bool contact = true;
  bool disk_full = false;

 private:
  std::string open_name_;
  Bytes open_;
};

}  // namespace ilp::test
