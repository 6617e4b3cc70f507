// The functions of service 8: names, arguments, what they do. The interface document and the Telecommander follow this
// table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

enum class Function : std::uint8_t {
  capture,
  capture_at,
  capture_series,
  capture_mode,
  flush_window,
  begin_strip,
  end_strip,
  refine_product,
  delete_product,
  begin_pass,
  end_pass,
  safe_mode,
  restart_component,
  suspend_transfer,
  resume_transfer,
  cancel_transfer,
  activate_file,
  count
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
