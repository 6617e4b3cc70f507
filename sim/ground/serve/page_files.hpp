// The files of the live page, which the build embeds in the program.
#pragma once

#include <span>
#include <string_view>

namespace ilp::serve {

struct PageFile {
  std::string_view name;  ///< file name, such as main.js
  std::string_view text;
};

[[nodiscard]] std::span<const PageFile> page_files();

}  // namespace ilp::serve
