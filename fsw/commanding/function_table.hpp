// The functions of service 8, as fsw/commanding/functions.inc has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

enum class Function : std::uint8_t {
#define FUNCTION(number, effect, name, arguments, completion, meaning) effect = (number),
#include "fsw/commanding/functions.inc"
};

struct FunctionInfo {
  Function function;
  const char* name;       ///< at most 8 characters
  const char* arguments;  ///< for documents; TIME is in the tailoring's time format
  std::uint8_t bytes;     ///< octets of its arguments, without TIME
  bool has_time;          ///< the arguments begin with TIME
  std::uint8_t optional;  ///< octets that may follow
  const char* description;
};

[[nodiscard]] std::span<const FunctionInfo> function_table();

/// The null pointer when no function has this name.
[[nodiscard]] const FunctionInfo* find_function(const char* name);

}  // namespace ilp
