// A truth value in one octet, for records.
#pragma once

#include <cstdint>

namespace ilp {

/// A truth value whose octet may come from a file or a link: 0 is false, every other value is true. (An octet of a
/// `bool` must be 0 or 1.)
class Flag {
 public:
  constexpr Flag() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): it is a bool.
  constexpr Flag(bool yes) : octet_(yes ? 1 : 0) {}
  // NOLINTNEXTLINE(google-explicit-constructor): it is a bool.
  constexpr operator bool() const { return octet_ != 0; }

 private:
  std::uint8_t octet_ = 0;
};

}  // namespace ilp
