// Expectations on a Status, printed by name.
#pragma once

#include <gtest/gtest.h>

#include <ostream>

#include "fsw/base/status.hpp"

namespace ilp {

inline void PrintTo(StatusCode code, std::ostream* out) {
  *out << status_name(code);
}

}  // namespace ilp

#define EXPECT_STATUS(expression, expected) EXPECT_EQ((expression).code, ::ilp::StatusCode::expected)
#define EXPECT_OK(expression) EXPECT_STATUS(expression, ok)
#define ASSERT_OK(expression) ASSERT_EQ((expression).code, ::ilp::StatusCode::ok)
