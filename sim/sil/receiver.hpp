// The far end of the link while a flight is simulated: confirms every whole file of the outbox.
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace ilp::sil {

class Receiver {
 public:
  Receiver(std::filesystem::path outbox, std::filesystem::path acknowledgements);
  /// Confirms what has arrived since the last call.
  void receive();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  [[nodiscard]] std::size_t files() const { return seen_.size(); }

 private:
  std::filesystem::path outbox_;
  std::filesystem::path acknowledgements_;
  std::set<std::string> seen_;
  std::uint64_t bytes_ = 0;
};

}  // namespace ilp::sil
