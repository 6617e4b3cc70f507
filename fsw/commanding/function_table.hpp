// The functions of service 8: names, arguments, what they do. The interface document and the Telecommander follow this
// table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// A number is never changed and never used again (tests/unit/cfg/numbers.txt).
enum class Function : std::uint8_t {
  capture = 1,
  capture_at = 2,
  capture_series = 3,
  capture_mode = 4,
  flush_window = 5,
  begin_strip = 6,
  end_strip = 7,
  refine_product = 8,
  delete_product = 9,
  begin_pass = 10,
  end_pass = 11,
  safe_mode = 12,
  restart_component = 13,
  suspend_transfer = 14,
  resume_transfer = 15,
  cancel_transfer = 16,
  activate_file = 17,
};

struct FunctionInfo {
  Function function;
  const char* name;       ///< at most 8 characters
  const char* arguments;  ///< for documents; TIME is in the tailoring's time format
  std::uint8_t bytes;     ///< of its arguments, without TIME
  bool has_time;          ///< begins with TIME
  std::uint8_t optional;  ///< octets that may follow
  const char* description;
};

[[nodiscard]] std::span<const FunctionInfo> function_table();

/// The null pointer when there is none with this name.
[[nodiscard]] const FunctionInfo* find_function(const char* name);

}  // namespace ilp
