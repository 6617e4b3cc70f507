// How long a component asks again for what the store does not give.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

/// The fault may pass: the same call may succeed later. Anything else is an answer.
[[nodiscard]] constexpr bool may_pass(const Status& status) {
  return status.is(StatusCode::io_error) || status.is(StatusCode::store_error) || status.is(StatusCode::store_full) ||
         status.is(StatusCode::store_damaged) || status.is(StatusCode::arena_exhausted);
}

}  // namespace ilp
