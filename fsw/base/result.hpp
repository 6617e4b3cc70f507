// A value, or the fault for which there is none: what a function returns that would need a Status and an output.
#pragma once

#include <concepts>

#include "fsw/base/status.hpp"

namespace ilp {

/// `Result<bool>` is the answer of a step that may find nothing to do: yes, no, or a fault.
template <typename Value>
class [[nodiscard]] Result {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): it allows `return true;`.
  constexpr Result(std::same_as<Value> auto value) : value_(value) {}
  /// Without a value: `fault` is not ok.
  // NOLINTNEXTLINE(google-explicit-constructor): it allows ILP_TRY, and `return StatusCode::not_ready;`.
  constexpr Result(const Status& fault) : status_(fault) {}
  // NOLINTNEXTLINE(google-explicit-constructor): as above.
  constexpr Result(StatusCode fault) : status_(fault) {}

  [[nodiscard]] constexpr bool ok() const { return status_.ok(); }
  [[nodiscard]] constexpr const Status& status() const { return status_; }
  /// Value{} where there is none.
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

/// Calls `slice` until it answers that there is no more to do.
template <typename Slice>
Status do_all(Slice slice) {
  for (bool more = true; more;) {  // bound: the slices of the caller's work
    ILP_TAKE(more, slice());
  }
  return {};
}

}  // namespace ilp
