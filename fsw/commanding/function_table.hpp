// The functions of service 8, as listed in fsw/commanding/functions.inc.
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
  std::uint8_t bytes;     ///< octets of the arguments, without TIME
  bool has_time;          ///< the arguments begin with TIME
  std::uint8_t optional;  ///< octets of an optional argument that may follow
  const char* description;
};

[[nodiscard]] std::span<const FunctionInfo> function_table();

/// Returns the null pointer if no function has this name.
[[nodiscard]] const FunctionInfo* find_function(const char* name);

}  // namespace ilp
