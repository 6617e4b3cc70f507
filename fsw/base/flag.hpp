// Yes or no in one octet, for records.
#pragma once

#include <cstdint>

namespace ilp {

/// A `bool` whose octet may come from a file or a link: every octet but 0 is a yes, where the octet of a `bool` must be
/// 0 or 1.
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
