// What is fuzzed: each target takes any octets, and throws when the flight software does something that it must not.
// The sanitizers find the rest.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace ilp::fuzz {

using Octets = std::span<const std::uint8_t>;

/// Telecommands, bodies of all services in all tailorings, time codes: total, and encoding says the same again.
void telecommand(Octets input);
/// CFDP PDUs: total, and encoding says the same again.
void cfdp_pdu(Octets input);
/// One transaction of each side: whatever comes, what is sent is a PDU within the file, and silence follows.
void cfdp_sender(Octets input);
void cfdp_receiver(Octets input);
/// Packets, PDUs, time, restarts and outages for Telecommander, FileDelivery and TelemetryReporter on one store.
void session(Octets input);

struct Target {
  const char* name;  ///< of its corpus too
  void (*run)(Octets input);
};
inline constexpr Target targets[] = {{"telecommand", telecommand},
                                     {"cfdp_pdu", cfdp_pdu},
                                     {"cfdp_sender", cfdp_sender},
                                     {"cfdp_receiver", cfdp_receiver},
                                     {"session", session}};

inline void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// Reads choices from the input; at its end everything is 0.
class Choices {
 public:
  explicit Choices(Octets input) : input_(input) {}
  [[nodiscard]] bool empty() const { return input_.empty(); }
  std::uint64_t number(std::size_t octets) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < octets; ++i) value = (value << 8U) | byte();
    return value;
  }
  std::uint8_t byte() {
    if (input_.empty()) return 0;
    const std::uint8_t value = input_.front();
    input_ = input_.subspan(1);
    return value;
  }
  std::uint32_t u16() { return static_cast<std::uint32_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  /// As many as a first octet says, as far as they are there.
  Octets bytes() { return take(byte()); }
  Octets take(std::size_t most) {
    const Octets part = input_.first(most < input_.size() ? most : input_.size());
    input_ = input_.subspan(part.size());
    return part;
  }
  Octets rest() { return take(input_.size()); }

 private:
  Octets input_;
};

}  // namespace ilp::fuzz
