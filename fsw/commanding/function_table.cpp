#include "fsw/commanding/function_table.hpp"

#include <cstring>
#include <string_view>

namespace ilp {
namespace {

constexpr std::uint8_t tag_bytes = 8;

/// Counts the octets of the arguments: u8, u16, u32 and f64 at the beginning of a word of the text.
constexpr std::uint8_t bytes_of(std::string_view arguments) {
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (i != 0 && arguments[i - 1] != ' ') continue;
    const std::string_view word = arguments.substr(i);
    bytes += word.starts_with("u8 ")    ? 1
             : word.starts_with("u16 ") ? 2
             : word.starts_with("u32 ") ? 4
             : word.starts_with("f64 ") ? 8
                                        : 0;
  }
  return static_cast<std::uint8_t>(bytes);
}

constexpr FunctionInfo row(Function function, std::string_view name, const char* arguments, const char* meaning) {
  const std::string_view text = arguments;
  const bool tagged = text.find("[tag") != std::string_view::npos;
  return {function,
          name.size() <= 8 ? name.data() : nullptr,
          arguments,
          bytes_of(text),
          text.starts_with("TIME"),
          tagged ? tag_bytes : std::uint8_t{0},
          meaning};
}

constexpr FunctionInfo table[] = {
#define FUNCTION(number, effect, name, arguments, completion, meaning) row(Function::effect, name, arguments, meaning),
#include "fsw/commanding/functions.inc"
};

}  // namespace

std::span<const FunctionInfo> function_table() {
  return table;
}

const FunctionInfo* find_function(const char* name) {
  for (const FunctionInfo& info : table) {
    if (std::strcmp(info.name, name) == 0) return &info;
  }
  return nullptr;
}

}  // namespace ilp
