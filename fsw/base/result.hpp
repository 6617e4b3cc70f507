// A value or a fault: the return type of a function that would otherwise need a Status and an output parameter.
#pragma once

#include <concepts>

#include "fsw/base/status.hpp"

namespace ilp {

/// A Result<bool> often means: true if something was found or done, false if not, or a fault.
template <typename Value>
class [[nodiscard]] Result {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): it allows `return true;`.
  constexpr Result(std::same_as<Value> auto value) : value_(value) {}
  /// A result without a value. `fault` must not be ok.
  // NOLINTNEXTLINE(google-explicit-constructor): it allows ILP_TRY, and `return StatusCode::not_ready;`.
  constexpr Result(const Status& fault) : status_(fault) {}
  // NOLINTNEXTLINE(google-explicit-constructor): as above.
  constexpr Result(StatusCode fault) : status_(fault) {}

  [[nodiscard]] constexpr bool ok() const { return status_.ok(); }
  [[nodiscard]] constexpr const Status& status() const { return status_; }
  /// The value; Value{} after a fault.
  [[nodiscard]] constexpr const Value& value() const { return value_; }

 private:
  Status status_;
  Value value_{};
};

}  // namespace ilp

#define ILP_RESULT_OF_LINE(line) ilp_result_##line
#define ILP_RESULT_NAME(line) ILP_RESULT_OF_LINE(line)
/// Declares a constant with the value of `expression`, a Result, or returns its fault from this function:
/// ILP_TAKE(const bool found, find(store, id, record));
#define ILP_TAKE(declaration, ...)                                                \
  const auto ILP_RESULT_NAME(__LINE__) = (__VA_ARGS__);                           \
  if (!ILP_RESULT_NAME(__LINE__).ok()) return ILP_RESULT_NAME(__LINE__).status(); \
  declaration = ILP_RESULT_NAME(__LINE__).value()

namespace ilp {

/// Calls `slice`, which returns a Result<bool>, until it returns false (no more to do) or a fault.
template <typename Slice>
Status do_all(Slice slice) {
  for (bool more = true; more;) {  // bound: the slices of the caller's work
    ILP_TAKE(more, slice());
  }
  return {};
}

}  // namespace ilp
